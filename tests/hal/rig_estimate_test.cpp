// A camera with two lenses is made of a simulated one: its depth is moved into a lens beside it, and must be found
// there.
#include "hal/imaging/rig_estimate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::hal::imaging {
namespace {

using ::testing::HasSubstr;

constexpr double kTurn = 0.01;  // about y

RigCalibration truth(const Intrinsics& colour) {
  RigCalibration rig;
  rig.colour = colour;
  rig.depth = colour;
  rig.depth->fx *= 0.95;
  rig.depth->fy *= 0.95;
  rig.depth->cx += 3;
  rig.pose.rotation = {std::cos(kTurn), 0, std::sin(kTurn), 0, 1, 0, -std::sin(kTurn), 0, std::cos(kTurn)};
  rig.pose.translation_m = {0.025, 0.003, 0};
  return rig;
}

ColourFromDepth inverse(const ColourFromDepth& pose) {
  const auto& r = pose.rotation;
  ColourFromDepth out{{r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]}, {}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out.translation_m[i] -= out.rotation[3 * i + j] * pose.translation_m[j];
  return out;
}

// What an estimator that begins with the makers' numbers says of a walk; the device's readings are (depth - offset) of
// the true ones, times `scale`.
Result<RigEstimator::Estimated> estimated(const std::string& room, double offset_m, double scale,
                                          const RigEstimator::Settings& settings = {}) {
  const auto camera = std::move(open_simulated(*parse_camera_address(room))).value();
  const RigCalibration rig = truth(camera->intrinsics());
  RigCalibration nominal = rig;
  nominal.pose = {};
  nominal.pose.translation_m = {0.02, 0, 0};
  auto estimator = std::move(RigEstimator::create(nominal, settings)).value();
  DepthRegistration beside(rig.colour, *rig.depth, inverse(rig.pose));
  FramePool pool(rig.colour, 1);
  Frame frame = pool.acquire();
  std::vector<std::uint16_t> depth(frame.view().depth.size());
  while (camera->grab(frame, {}) == Grab::frame) {
    beside.apply(frame.view().depth, depth);
    for (std::uint16_t& value : depth)
      if (value != 0) value = static_cast<std::uint16_t>(std::lround((value - offset_m * 5000) * scale));
    estimator.add(frame.view().rgb, depth);
  }
  return estimator.estimate();
}

const std::string kWalk = "simulated:living-room?fps=1&frames=16&seed=3";

TEST(RigEstimate, FindsTheDepthLensAndTheOffsetOfDepthAndSaysHowSure) {
  const auto found = estimated(kWalk, 0.02, 1);
  ASSERT_TRUE(found) << found.error().reason;
  const RigCalibration& rig = found->rig;
  EXPECT_NEAR(rig.pose.rotation[2], kTurn, 0.001);
  EXPECT_NEAR(rig.pose.rotation[3], 0, 0.001);
  EXPECT_NEAR(rig.pose.rotation[7], 0, 0.002);
  EXPECT_NEAR(rig.pose.translation_m[0], 0.025, 0.0015);
  EXPECT_NEAR(rig.pose.translation_m[1], 0.003, 0.0025);
  EXPECT_EQ(rig.pose.translation_m[2], 0) << "nothing tells it";
  EXPECT_TRUE(found->offset_told);
  EXPECT_NEAR(rig.depth_offset_m, 0.02, 0.004);
  for (const double sigma : found->lens.sigma) EXPECT_TRUE(sigma > 0 && sigma < 0.003) << sigma;
  EXPECT_LT(std::abs(rig.pose.translation_m[0] - 0.025), 4 * found->lens.sigma[3] + 0.0005);
  EXPECT_LT(std::abs(rig.depth_offset_m - 0.02), 3 * found->offset.sigma);
  EXPECT_FALSE(found->scale) << "nothing tells it";
  EXPECT_THAT(words_of(*found), HasSubstr("a larger room gives the same images"));
}

TEST(RigEstimate, NoOffsetIsFoundWhereThereIsNoneAndTheLensesDistanceTellsTheScale) {
  RigEstimator::Settings settings;
  settings.baseline_m = std::hypot(0.025, 0.003);
  const auto found = estimated(kWalk, 0, 1.2, settings);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_FALSE(found->offset_told) << found->offset.value << " +- " << found->offset.sigma;
  EXPECT_EQ(found->rig.depth_offset_m, 0);
  ASSERT_TRUE(found->scale);
  EXPECT_NEAR(found->scale->value, 5000 * 1.2, 4 * found->scale->sigma + 50);
  EXPECT_NEAR(found->scale->value, 5000 * 1.2, 0.1 * 5000) << "+- " << found->scale->sigma;
  EXPECT_LT(found->scale->sigma, 0.05 * 5000);
  EXPECT_EQ(found->rig.colour.depth_scale, found->scale->value);
  EXPECT_EQ(found->rig.depth->depth_scale, found->scale->value);
}

TEST(RigEstimate, WhatCannotBeToldIsRefusedWithItsReason) {
  const auto few = estimated("simulated:office?fps=1&frames=3&seed=3", 0, 1);
  ASSERT_FALSE(few);
  EXPECT_THAT(few.error().reason, HasSubstr("3 images are too few"));
  const auto dark = estimated(kWalk + "&black_at=1&fault_for=100&width=320&height=240", 0, 1);
  ASSERT_FALSE(dark);
  EXPECT_THAT(dark.error().reason, HasSubstr("places where both depth and colour change are too few"));
  RigCalibration one;
  EXPECT_THAT(RigEstimator::create(one, {}).error().reason, HasSubstr("no lens for depth"));
  RigEstimator::Settings wide;
  wide.baseline_m = 2;
  EXPECT_THAT(RigEstimator::create(truth({}), wide).error().reason, HasSubstr("at most 0.5 m"));
}

TEST(RigEstimate, ACalibrationThatWasWrittenIsRead) {
  RigCalibration rig = truth({});
  rig.depth_offset_m = -0.0125;
  rig.depth_none = 65535;
  const auto read = parse_rig_calibration(text_of(rig), "file");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->depth_none, rig.depth_none);
  EXPECT_NEAR(read->depth->fx, rig.depth->fx, 1e-6);
  EXPECT_EQ(read->depth_offset_m, rig.depth_offset_m);
  EXPECT_EQ(read->pose.translation_m, rig.pose.translation_m);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(read->pose.rotation[i], rig.pose.rotation[i], 1e-7);
  rig.depth.reset();
  rig.depth_offset_m = 0;
  EXPECT_FALSE(parse_rig_calibration(text_of(rig), "file")->depth);
  EXPECT_FALSE(parse_rig_calibration(text_of(rig) + "depth_offset_m 0.01\n", "file"));
}

TEST(RigEstimate, AnOffsetIsAddedWhenDepthIsRegistered) {
  Intrinsics k;
  k.width = k.height = 16;
  k.cx = k.cy = 7.5;
  DepthRegistration plain(k, k, {}), moved(k, k, {}, 0.02);
  std::vector<std::uint16_t> depth(256, 10000), out(256);
  depth[0] = 0;
  moved.apply(depth, out);
  EXPECT_EQ(out[128], 10100);
  plain.apply(depth, out);
  EXPECT_EQ(out[128], 10000);
}

}  // namespace
}  // namespace onemap::hal::imaging
