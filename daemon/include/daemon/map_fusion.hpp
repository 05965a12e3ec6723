#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "daemon/team_member.hpp"
#include "mapping/team/atlas.hpp"

namespace onemap::daemon {

// Builds the global map of a solution one robot after the other, in the solution's order, so that only one robot's
// submaps are decoded at a time. Used by one thread.
class MapFusion {
 public:
  explicit MapFusion(const mapping::AtlasConfig& config) : config_(config) {}

  void begin(const mapping::SolutionRecord& solution);  // anew; the map before is gone
  bool underway() const { return solution_.has_value() && next_ < solution_->robots.size(); }
  bool done() const { return solution_.has_value() && !underway(); }
  void abandon() { solution_.reset(); }  // there is no map

  const RobotId& next() const { return solution_->robots[next_].robot; }  // underway(): whose submaps are wanted
  // Fuses next()'s. False, and nothing is done, when stop() says true in between.
  bool add(const TeamMember& member, const std::function<bool()>& stop);

  const std::optional<mapping::SolutionRecord>& solution() const { return solution_; }  // underway or done
  std::size_t submaps() const { return submaps_; }                                      // records that went in
  const mapping::VoxelMap* map() const { return done() ? &atlas_->map() : nullptr; }
  std::uint64_t digest() const { return atlas_->digest(); }

 private:
  const mapping::AtlasConfig config_;
  std::unique_ptr<mapping::Atlas> atlas_;  // made for the first solution
  std::optional<mapping::SolutionRecord> solution_;
  std::size_t next_ = 0, submaps_ = 0;
};

}  // namespace onemap::daemon
