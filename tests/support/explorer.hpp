#pragma once
#include <string>
#include <utility>
#include <vector>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/records/keyframe.hpp"

namespace onemap::test {

// One robot's sealed keyframes and its true first pose in the room.
struct Explorer {
  std::vector<mapping::KeyframeRecord> keyframes;
  mapping::Pose T_world_first;
};

// A robot that maps a simulated room, from the address of its camera to the end of its frames.
inline Explorer explore(const std::string& address_text,
                        mapping::DescriptorKind features = mapping::DescriptorKind::surf) {
  Explorer out;
  const auto address = hal::parse_camera_address(address_text);
  auto camera = std::move(hal::open_simulated(*address).value());
  const auto truth = hal::simulated_truth(*address).value();
  const auto& q = truth[0].q_world_camera_xyzw;
  const auto& t = truth[0].t_world_camera_m;
  out.T_world_first = {mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}), mapping::Vector3d(t[0], t[1], t[2])};
  hal::FramePool pool(camera->intrinsics(), 2);
  mapping::LocalMapperConfig config;
  config.max_keyframes = 60;
  config.features = features;
  config.map.budget_bytes = 8u << 20;
  mapping::LocalMapper mapper(config, camera->intrinsics());
  for (;;) {
    hal::Frame frame = pool.acquire();
    if (camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    mapper.process(frame.view());
  }
  mapper.finish();
  mapping::KeyframeRecord record;
  while (mapper.take_keyframe(record)) out.keyframes.push_back(record);
  return out;
}

}  // namespace onemap::test
