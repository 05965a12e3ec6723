#pragma once
#include <string>
#include <vector>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/organized_cloud.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/team/survey.hpp"

namespace onemap::test {

// A depth grid as a mapper makes it of a frame.
inline mapping::DepthGrid depth_grid(std::span<const std::uint16_t> depth, const hal::Intrinsics& k) {
  mapping::OrganizedCloud cloud;
  mapping::organize(depth, k, mapping::DepthGrid::kMostWidth, mapping::DepthGrid::kMostHeight, cloud);
  mapping::DepthGrid grid;
  grid.width = mapping::DepthGrid::kMostWidth, grid.height = mapping::DepthGrid::kMostHeight;
  const auto fixed = [](float v) { return static_cast<std::int32_t>(std::lround(v * 1024)); };
  grid.fx_fy_cx_cy = {fixed(cloud.fx), fixed(cloud.fy), fixed(cloud.cx), fixed(cloud.cy)};
  for (const auto& p : cloud.points) grid.inverse_depth.push_back(mapping::grid_inverse_depth(p.z()));
  return grid;
}

// What a robot in a simulated room hands out, under its true poses.
struct SimulatedKeyframes {
  std::vector<mapping::DepthGrid> grids;
  std::vector<std::vector<std::uint8_t>> bodies;  // as records
  std::vector<mapping::Pose> poses;               // T_map_keyframe; the map's frame is the first camera's
  mapping::Pose T_world_map;                      // the room's: z up, its origin on the floor

  std::vector<mapping::PlacedKeyframe> placed() const {
    std::vector<mapping::PlacedKeyframe> out;
    for (std::size_t i = 0; i < bodies.size(); ++i) out.push_back({bodies[i], poses[i]});
    return out;
  }
};

// Every so many frames of the address make a keyframe.
inline SimulatedKeyframes simulated_keyframes(const std::string& text, std::size_t every) {
  const auto address = hal::parse_camera_address(text);
  auto camera = hal::open_simulated(*address);
  const auto truth = hal::simulated_truth(*address);
  hal::FramePool pool((*camera)->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  SimulatedKeyframes out;
  for (std::size_t i = 0; i < truth->size(); ++i) {
    if ((*camera)->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    const auto& t = (*truth)[i].t_world_camera_m;
    const auto& q = (*truth)[i].q_world_camera_xyzw;
    const mapping::Pose T{mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}), {t[0], t[1], t[2]}};
    if (i == 0) out.T_world_map = T;
    if (i % every != 0) continue;
    mapping::KeyframeRecord record;
    record.index = record.anchor = static_cast<std::uint32_t>(out.grids.size());
    record.grid = depth_grid(frame.view().depth, (*camera)->intrinsics());
    out.poses.push_back(out.T_world_map.inverse() * T);
    record.T_robot_keyframe = mapping::quantize(out.poses.back());
    out.bodies.push_back(encode(record));
    out.grids.push_back(std::move(record.grid));
  }
  return out;
}

}  // namespace onemap::test
