#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// Where a submap's anchor is in the global frame.
struct PlacedAnchor {
  std::uint32_t keyframe = 0;
  QuantizedPose T_map_anchor;
  bool operator==(const PlacedAnchor&) const = default;
};

// One life of a robot that is in the map. An anchor that is not listed keeps its odometry from the one before it, or
// from the first; with none listed the robot's own frame is the map's.
struct SolvedRobot {
  RobotId robot;
  std::uint64_t incarnation = 0;
  std::vector<PlacedAnchor> anchors;  // sorted by keyframe, each once; at most 4096
};

// The team's pose graph, solved: what everybody's map is made of.
struct SolutionRecord {                             // lane poses; of the elected robot; the last one counts
  RobotId reference;                                // the global frame hangs on this robot's first anchor
  std::vector<SolvedRobot> robots;                  // in the map, sorted by id, the reference among them; at most 1024
  std::uint32_t links_used = 0, links_refused = 0;  // pairs of keyframes
};

std::vector<std::uint8_t> encode(const SolutionRecord& record);
Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
