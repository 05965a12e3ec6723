#pragma once
#include <string>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/ray_table.hpp"
#include "mapping/local/surface.hpp"
#include "mapping/local/voxel_map.hpp"
#include "render/scene.hpp"
#include "render/tidy.hpp"

namespace onemap::test {

// A simulated room as a robot has it: fused under its true poses, in the frame of its first camera.
struct SimulatedRoom {
  render::Scene scene;
  mapping::Vector3f up;  // the truth
};

inline SimulatedRoom simulated_room(const std::string& text) {
  const auto address = hal::parse_camera_address(text);
  auto camera = hal::open_simulated(*address);
  const auto truth = hal::simulated_truth(*address);
  hal::FramePool pool((*camera)->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  const mapping::RayTable rays((*camera)->intrinsics());
  mapping::VoxelMapConfig config;
  config.voxel_m = 0.04f;
  config.truncation_m = 0.12f;
  mapping::VoxelMap map(config);
  SimulatedRoom room;
  room.scene.title = text;
  room.scene.robots = {{"robot1", render::robot_color(0), {}, {}}};
  mapping::Pose T_first_world;
  for (std::size_t i = 0; i < truth->size(); ++i) {
    if ((*camera)->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    const auto& t = (*truth)[i].t_world_camera_m;
    const auto& q = (*truth)[i].q_world_camera_xyzw;
    const mapping::Pose T{mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}), {t[0], t[1], t[2]}};
    if (i == 0) T_first_world = T.inverse();
    const mapping::Pose pose = T_first_world * T;
    if (i % 3 == 0) map.integrate(frame.view(), rays, pose);
    room.scene.robots[0].poses.push_back(pose);
    if (i % 3 == 0) room.scene.robots[0].keyframe_poses.push_back(pose);
  }
  room.scene.mesh = render::tidied(mapping::extract_mesh(map));
  room.up = (T_first_world.R * mapping::Vector3d(0, 0, 1)).cast<float>();
  return room;
}

}  // namespace onemap::test
