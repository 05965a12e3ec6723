// What a simulated camera does when its address tells it to fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/backends/simulated.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using testing::Each;

struct Taken {
  std::vector<Grab> grabs;
  std::vector<std::uint64_t> indices;  // of the frames
  std::vector<FrameTime> times;
  std::vector<std::vector<std::uint8_t>> rgb;
  std::vector<std::vector<std::uint16_t>> depth;
  std::string error;
  Intrinsics intrinsics;
};

Taken take(const std::string& options) {
  auto camera = open_simulated(*parse_camera_address("simulated:office?width=64&height=48&frames=30&" + options));
  if (!camera) throw std::runtime_error(camera.error().text());
  FramePool pool((*camera)->intrinsics(), 1);
  Frame frame = pool.acquire();
  Taken taken;
  for (Grab grab = Grab::frame; grab != Grab::end;) {
    grab = (*camera)->grab(frame, 100ms);
    taken.grabs.push_back(grab);
    if (grab == Grab::gone) taken.error = (*camera)->last_error().text();
    if (grab != Grab::frame) continue;
    taken.indices.push_back(frame.index);
    taken.times.push_back(frame.colour_time);
    taken.rgb.emplace_back(frame.rgb().begin(), frame.rgb().end());
    taken.depth.emplace_back(frame.depth().begin(), frame.depth().end());
  }
  EXPECT_EQ((*camera)->counters().frames, taken.indices.size());
  EXPECT_EQ((*camera)->frames_expected(), 0u);
  taken.intrinsics = (*camera)->intrinsics();
  return taken;
}

const Taken& good() {
  static const Taken taken = take("seed=1");
  return taken;
}

TEST(SimulatedFaults, UnpluggedItIsGoneAndComesBackLater) {
  const Taken taken = take("unplug_at=10&back_after=6");
  EXPECT_EQ(std::ranges::count(taken.grabs, Grab::gone), 2) << "100 ms are three frames";
  EXPECT_THAT(taken.error, testing::HasSubstr("unplugged"));
  ASSERT_EQ(taken.indices.size(), 24u);
  EXPECT_EQ(taken.indices[9], 9u);
  EXPECT_EQ(taken.indices[10], 16u) << "its time went on";
  EXPECT_EQ(taken.rgb[10], good().rgb[16]);
  EXPECT_EQ(take("unplug_at=10").indices.size(), 10u) << "and never, if it is not said";
}

TEST(SimulatedFaults, PixelsFailFromAFrameOnForAsLongAsIsSaid) {
  const Taken frozen = take("freeze_at=10&fault_for=5");
  for (std::size_t i = 10; i < 15; ++i) {
    EXPECT_EQ(frozen.rgb[i], good().rgb[9]);
    EXPECT_EQ(frozen.depth[i], good().depth[9]);
    EXPECT_EQ(frozen.times[i], good().times[i]);
  }
  EXPECT_EQ(frozen.rgb[15], good().rgb[15]);
  const Taken black = take("black_at=10&fault_for=5"), white = take("saturate_at=10&fault_for=5");
  EXPECT_THAT(black.rgb[12], Each(testing::Le(3)));
  EXPECT_EQ(black.depth[12], good().depth[12]);
  EXPECT_THAT(white.rgb[12], Each(testing::Ge(252)));
  const Taken blind = take("no_depth_at=10&fault_for=5");
  EXPECT_THAT(blind.depth[12], Each(0));
  EXPECT_EQ(blind.rgb, good().rgb);
  for (const Taken* taken : {&black, &white, &blind}) {
    EXPECT_EQ(taken->rgb[9], good().rgb[9]);
    EXPECT_EQ(taken->rgb[15], good().rgb[15]);
    EXPECT_EQ(taken->depth[15], good().depth[15]);
  }
}

TEST(SimulatedFaults, TimesGoBackByAnHour) {
  const Taken taken = take("time_back_at=10&fault_for=5");
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_EQ(good().times[i] - taken.times[i], i >= 10 && i < 15 ? Duration(1h) : Duration::zero()) << i;
}

TEST(SimulatedFaults, WrongIntrinsicsAreClaimedAndThePicturesStay) {
  const Taken taken = take("fx_scale=1.25");
  EXPECT_DOUBLE_EQ(taken.intrinsics.fx, 1.25 * good().intrinsics.fx);
  EXPECT_DOUBLE_EQ(taken.intrinsics.fy, 1.25 * good().intrinsics.fy);
  EXPECT_DOUBLE_EQ(taken.intrinsics.cx, good().intrinsics.cx);
  EXPECT_EQ(taken.rgb, good().rgb);
}

}  // namespace
}  // namespace onemap::hal
