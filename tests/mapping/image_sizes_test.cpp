// Cameras of other sizes than 640x480: the same walk is followed, with memory that fits the images.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "hal/backends/simulated.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/count_allocations.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kFrames = 45;

struct Followed {
  std::size_t tracked = 0, blocks = 0;
  double worst_m = 0;  // distance of a camera position from the truth, both seen from the first camera
  std::uint64_t allocations = 0;
};

Vector3d position(const hal::SimulatedPose& p) {
  return {p.t_world_camera_m[0], p.t_world_camera_m[1], p.t_world_camera_m[2]};
}

Matrix3d turn(const hal::SimulatedPose& p) {
  const auto& q = p.q_world_camera_xyzw;
  return from_quaternion_wxyz({q[3], q[0], q[1], q[2]});
}

Followed follow(const std::string& size) {
  const auto address = hal::parse_camera_address("simulated:living-room?seed=3&frames=45&" + size);
  auto camera = std::move(hal::open_simulated(*address).value());
  const auto truth = hal::simulated_truth(*address).value();
  hal::FramePool pool(camera->intrinsics(), 1);
  LocalMapperConfig config;
  config.max_keyframes = 40;
  config.map.budget_bytes = 32u << 20;
  EXPECT_TRUE(check(config, camera->intrinsics()).ok());
  LocalMapper mapper(config, camera->intrinsics());
  Followed out;
  for (std::size_t i = 0; i < kFrames; ++i) {
    hal::Frame frame = pool.acquire();
    EXPECT_EQ(camera->grab(frame, std::chrono::milliseconds(0)), hal::Grab::frame);
    const std::uint64_t before = test::allocations();
    const FrameReport report = mapper.process(frame.view());
    out.allocations += test::allocations() - before;
    if (report.state != TrackState::tracking) continue;
    ++out.tracked;
    const Vector3d moved = turn(truth[0]).transpose() * (position(truth[i]) - position(truth[0]));
    out.worst_m = std::max(out.worst_m, (report.T_robot_camera.t - moved).norm());
  }
  out.blocks = mapper.counters().blocks;
  return out;
}

class ImageSizes : public testing::TestWithParam<const char*> {};

TEST_P(ImageSizes, AWalkIsFollowedAndMapped) {
  const Followed followed = follow(GetParam());
  EXPECT_EQ(followed.tracked, kFrames);
  EXPECT_LT(followed.worst_m, 0.03);
  EXPECT_GT(followed.blocks, 500u);
  EXPECT_EQ(followed.allocations, 0u);
}
INSTANTIATE_TEST_SUITE_P(All, ImageSizes,
                         testing::Values("width=320&height=240", "width=848&height=480", "width=1280&height=720"),
                         [](const auto& size) {
                           std::string name = size.param;
                           std::erase_if(name, [](char c) { return c == '=' || c == '&'; });
                           return name;
                         });

}  // namespace
}  // namespace onemap::mapping
