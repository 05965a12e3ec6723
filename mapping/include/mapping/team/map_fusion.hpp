#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mapping/records/frontier.hpp"
#include "mapping/team/atlas.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::mapping {

// What a map is made of: of these chains so many records, placed as the solution says.
struct MapTarget {
  SolutionRecord solution;
  std::vector<ChainExtent> extents;  // sorted by chain; a chain that is not listed has nothing in the map
  bool operator==(const MapTarget&) const = default;
};

MapParameters map_parameters(const AtlasConfig& config);  // of a map that a robot with this configuration can hold

// Of the solution's chains all that is here.
std::vector<ChainExtent> everything_here(const TeamLog& log, const SolutionRecord& solution);
bool holds(const TeamLog& log, const std::vector<ChainExtent>& extents);  // all of it is here

// Builds the map of a target one submap after the other, and from there that of the next one: only submaps that have
// got more, or whose anchor moved, are fused again. The map is a function of the target alone. Only one submap is
// decoded at a time, and of that no more than half as many bytes as the map itself may have; what does not fit is left
// out and counted, from the oldest. A submap of which a body cannot be read stays in the map as it is there; then the
// map is no target's, has no digest, and is aimed at again. Used by one thread.
class MapFusion {
 public:
  // read: of records that the log holds without their bodies.
  explicit MapFusion(std::size_t budget_bytes, ReadRecord read = {})
      : budget_bytes_(budget_bytes), read_(std::move(read)) {}

  // Goes there from now on, from wherever it is. The log must hold the target.
  void aim(const TeamLog& log, MapTarget target);
  bool underway() const { return target_.has_value() && !todo_.empty(); }
  bool done() const { return target_.has_value() && todo_.empty(); }
  bool at(const MapTarget& target) const { return done() && aims_at(target); }
  bool aims_at(const MapTarget& target) const { return target_ && *target_ == target && unread_ == 0; }
  // underway(): fuses the next submap. False, and nothing is done, when stop() says true in between.
  bool step(const std::function<bool()>& stop);

  const std::optional<MapTarget>& target() const { return target_; }
  const SolutionRecord* solution() const { return done() ? &target_->solution : nullptr; }
  const VoxelMap* map() const { return done() ? &atlas_->map() : nullptr; }
  // Of the map and of where the solution puts whom, whatever lives these are; done(). 0: something could not be read.
  std::uint64_t digest() const;

  std::size_t submaps() const { return submaps_; }                    // records that are in the target
  std::size_t submaps_left_out() const;                               // beyond what may be decoded
  std::uint64_t blocks_unplaced() const { return blocks_unplaced_; }  // hung on an anchor nobody knows
  std::uint64_t submaps_fused() const { return fused_count_; }        // so far, again and again
  std::size_t submaps_unread() const { return unread_; }              // on the way to this target

  struct Malformed {  // or unread
    RecordId id;
    std::string reason;
  };
  std::vector<Malformed> take_malformed() { return std::exchange(malformed_, {}); }

 private:
  struct SubmapId {  // in the order in which they are fused from nothing
    ChainId chain;
    std::uint32_t anchor = 0;
    auto operator<=>(const SubmapId&) const = default;
  };
  struct Version {
    QuantizedPose T_map_anchor;
    std::vector<RecordPtr> records;  // in the order of their log
    std::size_t left_out = 0;
    bool same(const Version& other) const { return T_map_anchor == other.T_map_anchor && records == other.records; }
  };
  using Versions = std::map<SubmapId, Version>;
  Versions wanted(const TeamLog& log);
  struct Decoded {
    explicit Decoded(std::size_t max_blocks) : submaps(max_blocks) {}
    LatestSubmaps submaps;
    std::size_t left_out = 0;
    std::vector<Malformed> malformed, unread;
  };
  bool decode(const Version& version, Decoded& into, const std::function<bool()>& stop) const;
  void replace(const SubmapId& id, const Decoded& before, const Decoded& after);
  void start_over();
  void prepare(const MapParameters& map);
  std::size_t most_decoded() const;

  const std::size_t budget_bytes_;
  const ReadRecord read_;
  std::unique_ptr<Atlas> atlas_;
  MapParameters parameters_;
  std::optional<MapTarget> target_;
  Versions wanted_, fused_;
  std::vector<SubmapId> todo_;  // the next one is the last
  bool from_nothing_ = false;   // in order, so that what is refused for want of room follows from the target
  std::size_t submaps_ = 0, unread_ = 0;
  std::uint64_t blocks_unplaced_ = 0, fused_count_ = 0;
  std::vector<Malformed> malformed_;
};

}  // namespace onemap::mapping
