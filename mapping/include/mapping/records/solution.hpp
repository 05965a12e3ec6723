#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/geometry.hpp"
#include "mapping/records/chain_id.hpp"

namespace onemap::mapping {

// Where a submap's anchor is in the global frame.
struct PlacedAnchor {
  std::uint32_t keyframe = 0;
  QuantizedPose T_map_anchor;
  bool operator==(const PlacedAnchor&) const = default;
};

// One life of a robot that is in the map. Between two anchors that are listed its way is bent evenly, before and behind
// them it goes on by odometry (placed_anchors.hpp); with none listed the robot's own frame is the map's.
struct SolvedRobot {
  ChainId chain;
  std::vector<PlacedAnchor> anchors;  // sorted by keyframe, each once; at most 16,384
  bool operator==(const SolvedRobot&) const = default;
};

// What the global map is like, whatever each robot's configuration says: voxels as the elected robot has them, and as
// many blocks as the robot with the least room can hold.
struct MapParameters {
  static constexpr std::uint32_t kMostBlocks = 1u << 24;

  std::int32_t voxel_um = 20'000, truncation_um = 60'000;  // micrometres; 1 mm to 1 m, and 1 to 100 voxels
  std::uint32_t blocks = 1u << 20;                         // at most so many; 1 to 2^24
  bool operator==(const MapParameters&) const = default;
};

// A direction, in millionths of a unit vector's length.
struct UpDirection {
  std::array<std::int32_t, 3> millionths{0, -1'000'000, 0};  // up in the frame of a level camera
  bool operator==(const UpDirection&) const = default;
};
UpDirection up_direction(const Vector3f& up);  // of a unit vector
Vector3f unit_vector(const UpDirection& up);

// The team's pose graph, solved: what everybody's map is made of.
struct SolutionRecord {                             // lane poses; of the elected robot; the last one counts
  ChainId reference;                                // the global frame hangs on this chain's first anchor
  std::vector<SolvedRobot> robots;                  // in the map, sorted by chain, the reference among them; <= 1024
  std::uint32_t links_used = 0, links_refused = 0;  // pairs of keyframes
  MapParameters map;
  UpDirection up;  // in the global frame: for plans, pictures and models; no digest depends on it
  bool operator==(const SolutionRecord&) const = default;
};

// One life alone, where its own odometry has it.
SolutionRecord alone_on_map(const ChainId& chain);

std::vector<std::uint8_t> encode(const SolutionRecord& record);
Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body);
std::uint64_t digest(const SolutionRecord& record);  // XXH64 of its encoding

}  // namespace onemap::mapping
