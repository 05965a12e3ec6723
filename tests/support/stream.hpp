#pragma once
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/geometry.hpp"

namespace onemap::test {

// The frames of a simulated camera, one after the other, and where it truly was.
struct Stream {
  explicit Stream(const std::string& address_text) {
    auto address = hal::parse_camera_address(address_text);
    EXPECT_TRUE(address.ok());
    auto opened = hal::open_simulated(*address);
    EXPECT_TRUE(opened.ok()) << opened.error().text();
    camera = std::move(opened.value());
    pool.emplace(camera->intrinsics(), 2);
    truth = hal::simulated_truth(*address).value();
  }
  std::optional<hal::Frame> next() {
    hal::Frame frame = pool->acquire();
    if (camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) return std::nullopt;
    return frame;
  }
  const hal::Intrinsics& intrinsics() const { return camera->intrinsics(); }

  std::unique_ptr<hal::DepthCamera> camera;
  std::optional<hal::FramePool> pool;
  std::vector<hal::SimulatedPose> truth;
};

inline mapping::Pose truth_pose(const hal::SimulatedPose& p) {
  const auto& q = p.q_world_camera_xyzw;
  return {mapping::from_quaternion_wxyz({q[3], q[0], q[1], q[2]}),
          mapping::Vector3d(p.t_world_camera_m[0], p.t_world_camera_m[1], p.t_world_camera_m[2])};
}

}  // namespace onemap::test
