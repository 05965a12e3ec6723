#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/trajectory.hpp"
#include "render/scene.hpp"

namespace onemap::daemon {

// One robot's way, as its records say it, and where its frame lies in the map's.
struct SavedPath {
  std::string name;
  render::Color color{};
  mapping::QuantizedPose T_map_robot;
  std::vector<mapping::QuantizedPose> poses;      // T_robot_camera of every tracked frame
  std::vector<mapping::QuantizedPose> keyframes;  // T_robot_keyframe
};

// A map as bytes that never change: its blocks as submap records (means of the voxels, compressed) and the robots'
// ways, and which way is up where the map says it. What draws pictures and models gets this, so that it needs nothing
// of a running daemon but a file.
std::vector<std::uint8_t> save_map(const std::string& title, std::span<const SavedPath> paths,
                                   const mapping::VoxelMap& map,
                                   const std::optional<mapping::UpDirection>& up = std::nullopt);

// The mesh, title and paths of a saved map. The error names `place` and what is wrong; any bytes give one or the other.
Result<render::Scene> load_map(const std::string& place, std::span<const std::uint8_t> bytes);

}  // namespace onemap::daemon
