#pragma once
#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/records/keyframe.hpp"
#include "support/stream.hpp"

namespace onemap::test {

// One robot's sealed keyframes, and its true poses in the room: that of each keyframe, and its first one.
struct Explorer {
  std::vector<mapping::KeyframeRecord> keyframes;
  std::vector<mapping::Pose> T_world_keyframe;
  mapping::Pose T_world_first;
};

// A robot that maps a simulated room, from the address of its camera to the end of its frames.
inline Explorer explore(const std::string& address_text,
                        mapping::DescriptorKind features = mapping::DescriptorKind::surf) {
  Explorer out;
  const auto address = hal::parse_camera_address(address_text);
  auto camera = std::move(hal::open_simulated(*address).value());
  const auto truth = hal::simulated_truth(*address).value();
  out.T_world_first = truth_pose(truth[0]);
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
  while (mapper.take_keyframe(record)) {
    const auto at = std::ranges::find(truth, record.time, &hal::SimulatedPose::time);
    if (at == truth.end()) throw std::runtime_error("a keyframe of a time at which the camera saw nothing");
    out.T_world_keyframe.push_back(truth_pose(*at));
    out.keyframes.push_back(record);
  }
  return out;
}

}  // namespace onemap::test
