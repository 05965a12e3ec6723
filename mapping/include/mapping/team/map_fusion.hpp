#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mapping/team/atlas.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::mapping {

// Builds the global map of a solution one robot after the other, in the solution's order, so that only one robot's
// submaps are decoded at a time; and of that robot no more than as many bytes as the global map itself may have. What
// does not fit is left out and counted, from the oldest. Used by one thread.
class MapFusion {
 public:
  explicit MapFusion(const AtlasConfig& config) : config_(config) {}

  void begin(const SolutionRecord& solution);  // anew; the map before is gone
  bool underway() const { return solution_.has_value() && next_ < solution_->robots.size(); }
  bool done() const { return solution_.has_value() && !underway(); }

  const RobotId& next() const { return solution_->robots[next_].robot; }  // underway(): whose submaps are wanted
  // Fuses next()'s. False, and nothing is done, when stop() says true in between.
  bool add(const TeamMember& member, const std::function<bool()>& stop);

  bool outdated(const TeamLog& log) const;  // a robot that is in began a new life
  bool complete(const TeamLog& log) const;  // of all robots that are in, all submaps and anchors that are here went in

  const std::optional<SolutionRecord>& solution() const { return solution_; }  // underway or done
  std::size_t submaps() const { return submaps_; }                             // records that went in
  std::size_t submaps_left_out() const { return submaps_left_out_; }           // beyond what may be decoded
  const VoxelMap* map() const { return done() ? &atlas_->map() : nullptr; }
  std::uint64_t digest() const;  // of the map and of where the solution puts whom, whatever lives these are
  std::uint64_t blocks_unplaced() const { return atlas_ ? atlas_->counters().blocks_unplaced : 0; }  // no known anchor

  // Records whose content turned out to be malformed; each is told whenever it was to be fused.
  struct Malformed {
    RecordId id;
    std::string reason;
  };
  std::vector<Malformed> take_malformed() { return std::exchange(malformed_, {}); }

 private:
  struct Added {
    std::uint64_t incarnation = 0;
    std::size_t submaps = 0, keyframes = 0;
  };
  const AtlasConfig config_;
  std::unique_ptr<Atlas> atlas_;  // made for the first solution
  std::optional<SolutionRecord> solution_;
  std::size_t next_ = 0, submaps_ = 0, submaps_left_out_ = 0;
  std::vector<Added> added_;  // of the solution's robots before next_
  std::vector<Malformed> malformed_;
};

}  // namespace onemap::mapping
