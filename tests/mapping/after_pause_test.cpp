// A camera that gives nothing for seconds while it stands nearly still, as when it was plugged in again.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mapping/local/local_mapper.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kPauseAt = 8;

// Where the camera is at its last frame when frames from kPauseAt on come so much later.
Pose last_pose(const std::string& address, Duration pause) {
  test::Stream stream(address);
  LocalMapper mapper({}, stream.intrinsics());
  Pose last;
  std::size_t i = 0;
  while (const auto frame = stream.next()) {
    hal::FrameView view = frame->view();
    if (i >= kPauseAt) view.colour_time += pause, view.depth_time += pause;
    if (i++ == kPauseAt) continue;  // the one that was cut off
    const FrameReport report = mapper.process(view);
    EXPECT_EQ(report.state, TrackState::tracking) << "frame " << i;
    last = report.T_robot_camera;
  }
  return last;
}

// Where the image is small colour is poor, and the motion expects nothing any longer: depth helps all the same.
TEST(AfterAPause, TheMapGoesOnWhereItWas) {
  for (const char* room : {"living-room?seed=6", "house?seed=4", "office?seed=6"}) {
    const std::string address = fmt::format("simulated:{}&frames=21&width=320&height=240", room);
    const Pose straight = last_pose(address, Duration::zero());
    const Pose paused = last_pose(address, std::chrono::milliseconds(2800));
    EXPECT_LT((paused.t - straight.t).norm(), 0.001) << room;  // by colour alone 8, 14 and 14 mm
  }
}

}  // namespace
}  // namespace onemap::mapping
