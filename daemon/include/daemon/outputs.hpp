#pragma once
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/trajectory.hpp"
#include "render/scene.hpp"

namespace onemap::daemon {

// TUM format: `time tx ty tz qx qy qz qw` a pose, metres, time with 6 decimals printed from its integer nanoseconds.
// Each pose is T_frame_robot * T_robot_camera.
std::string trajectory_text(const std::vector<mapping::StampedPose>& poses, const mapping::Pose& T_frame_robot = {});

// Writes text whole or not at all.
Status write_text(const std::string& file, const std::string& text);

// Makes the folder with its parents; the error names the folder.
Status make_folder(const std::string& folder);

// One robot's way through a scene whose frame is T_scene_robot away from the robot's own.
render::RobotPath make_path(const std::string& name, render::Color color,
                            const std::vector<mapping::StampedPose>& poses,
                            const std::vector<mapping::QuantizedPose>& keyframes,
                            const mapping::Pose& T_scene_robot = {});

// A map to be drawn: STEM.png, STEM.glb, STEM.ply.
struct MapPicture {
  std::string stem;  // path without the ending
  const mapping::VoxelMap* map = nullptr;
  render::Scene scene;  // without its mesh, which comes from the map
};

// What was written of a map.
struct PictureSize {
  std::uint64_t vertices = 0;  // of the model files
};

// Draws and writes in a process of its own (the renderer's software driver is large and not ours: neither its memory
// nor a fault of it is the daemon's) and waits for it. Call when no other thread runs. Errors went to the child's
// stderr. sizes: of those that were written, in their order.
Status write_pictures(std::vector<MapPicture> pictures, std::vector<PictureSize>& sizes);

}  // namespace onemap::daemon
