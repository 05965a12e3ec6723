#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/records/solution.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::mapping {

// A keyframe's record and where the map has it.
struct PlacedKeyframe {
  std::span<const std::uint8_t> body;  // of a KeyframeRecord; one that does not decode is left out
  Pose T_map_keyframe;
};

// All keyframes of a solution's robots that are here, in the order of the solution. Valid while the log is not changed.
std::vector<PlacedKeyframe> placed_keyframes(const TeamLog& log, const SolutionRecord& solution);

// Up of keyframes on a map (up_of() with the cameras' mean up for the prior), looking at `most` of them at most,
// evenly.
Vector3f up_of_keyframes(std::span<const PlacedKeyframe> keyframes, std::size_t most);

// Which way is up in the map of a solution, for its record. Remembers what it found. Used by one thread.
class MapUp {
 public:
  // From the records and the solution's anchors alone.
  UpDirection final(const TeamLog& log, const SolutionRecord& solution);
  // While robots map: that of the solution in use, until there are half as many keyframes more than when up was last
  // looked for, or the map has another reference.
  UpDirection now(const TeamLog& log, const SolutionRecord& solution, const SolutionRecord* in_use);

 private:
  struct Final {
    std::uint64_t revision = 0;
    UpDirection up;
  };
  std::optional<Final> final_;
  std::size_t looked_at_ = 0;  // keyframes that there were
};

}  // namespace onemap::mapping
