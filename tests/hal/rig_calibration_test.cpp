#include "hal/imaging/rig_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace onemap::hal::imaging {
namespace {

using testing::HasSubstr;

const std::string kColour = "width 1280\nheight 720\nfx 900\nfy 901\ncx 640\ncy 360\ndepth_scale 1000\n";
const std::string kDepth =
    "depth_width 848\ndepth_height 480\ndepth_fx 420\ndepth_fy 420\ndepth_cx 423.5\ndepth_cy 239.5\n";

std::string error_of(const std::string& text) {
  const auto rig = parse_rig_calibration(text, "c");
  return rig ? "" : rig.error().text();
}

TEST(RigCalibration, WithoutADepthLensDepthIsRegistered) {
  const auto rig = parse_rig_calibration(kColour + "# my camera\nk1 0.1\ndepth_none 65535\n", "c");
  ASSERT_TRUE(rig.ok()) << rig.error().text();
  EXPECT_FALSE(rig->depth.has_value());
  EXPECT_EQ(rig->colour.width, 1280);
  EXPECT_EQ(rig->colour.fy, 901);
  EXPECT_EQ(rig->colour.k1, 0.1);
  EXPECT_EQ(rig->colour.depth_scale, 1000);
  EXPECT_EQ(rig->depth_none, 65535);
  EXPECT_EQ(rig->noise, DepthNoise{});
}

TEST(RigCalibration, TwoLensesAndTheirPose) {
  const double half = 0.05, c = std::cos(half), s = std::sin(half);  // 0.1 rad about y
  const auto rig = parse_rig_calibration(kColour + kDepth + "colour_from_depth_x 0.015\ncolour_from_depth_qy " +
                                             std::to_string(s) + "\ncolour_from_depth_qw " + std::to_string(c) +
                                             "\nnoise_least_m 0.001\nnoise_growth_per_m 0.004\nnoise_best_m 0.3\n",
                                         "c");
  ASSERT_TRUE(rig.ok()) << rig.error().text();
  ASSERT_TRUE(rig->depth.has_value());
  EXPECT_EQ(rig->depth->width, 848);
  EXPECT_EQ(rig->depth->depth_scale, 1000);
  EXPECT_EQ(rig->pose.translation_m[0], 0.015);
  EXPECT_NEAR(rig->pose.rotation[2], std::sin(0.1), 1e-6);
  EXPECT_NEAR(rig->pose.rotation[0], std::cos(0.1), 1e-6);
  EXPECT_EQ(rig->noise, (DepthNoise{0.001, 0.004, 0.3}));
}

TEST(RigCalibration, ErrorsSayWhereAndWhat) {
  EXPECT_THAT(error_of("width 1280\nfocus 3\n"), HasSubstr("c:2: unknown key 'focus'"));
  EXPECT_THAT(error_of("width 12.5\n"), HasSubstr("c:1: width must be a whole number"));
  EXPECT_THAT(error_of("fx 0\n"), HasSubstr("c:1: fx must be positive"));
  EXPECT_THAT(error_of("fx inf\n"), HasSubstr("c:1: fx: 'inf' is not a number"));
  EXPECT_THAT(error_of("fx 1 2\n"), HasSubstr("c:1: 3 words"));
  EXPECT_THAT(error_of("fx 1\nfx 1\n"), HasSubstr("c:2: fx was given in line 1"));
  EXPECT_THAT(error_of("fx 1\n"), HasSubstr("c: the calibration lacks width height fy cx cy depth_scale"));
  EXPECT_THAT(error_of(kColour + "depth_fx 3\n"), HasSubstr("lacks depth_width depth_height depth_fy"));
  EXPECT_THAT(error_of(kColour + "colour_from_depth_x 0.1\n"), HasSubstr("lacks depth_width"));
  EXPECT_THAT(error_of(kColour + kDepth + "colour_from_depth_x 15\n"), HasSubstr("more than a metre"));
  EXPECT_THAT(error_of(kColour + kDepth + "colour_from_depth_qy 0.5\n"), HasSubstr("length"));
  EXPECT_THAT(error_of(kColour + kDepth + "colour_from_depth_qy 0.6\ncolour_from_depth_qw 0.8\n"),
              HasSubstr("30 degrees"));
  EXPECT_THAT(error_of(kColour + "depth_none 70000\n"), HasSubstr("from 0 to 65535"));
  EXPECT_THAT(error_of("noise_least_m 0\n"), HasSubstr("c:1: noise_least_m must be within 1e-05 to 0.1"));
  EXPECT_THAT(error_of("noise_growth_per_m 3\n"), HasSubstr("c:1: noise_growth_per_m must be within 0 to 0.1"));
  EXPECT_THAT(error_of("noise_best_m -1\n"), HasSubstr("c:1: noise_best_m must be within 0 to 10"));
}

// Registration counts in whole numbers of 32 bits: what no camera has would take it out of them.
TEST(RigCalibration, LensesThatNoCameraHasAreRefusedWhereTheyStand) {
  const auto with = [](std::string text, const std::string& key, const std::string& value) {
    const std::size_t at = ("\n" + text).find("\n" + key + " "), end = text.find('\n', at);
    return at == std::string::npos ? text + key + " " + value + "\n" : text.replace(at, end - at, key + " " + value);
  };
  const std::string rig = kColour + kDepth;
  ASSERT_EQ(error_of(rig), "");
  EXPECT_THAT(error_of(with(rig, "fx", "1e30")),
              HasSubstr("c:3: fx: 1e+30 is not within 128 to 25600, for images of 1280x720"));
  EXPECT_THAT(error_of(with(rig, "depth_fx", "1e-30")),
              HasSubstr("c:10: depth_fx: 1e-30 is not within 84.8 to 16960, for images of 848x480"));
  EXPECT_THAT(error_of(with(rig, "depth_fy", "9")), HasSubstr("c:11: depth_fy"));
  EXPECT_THAT(error_of(with(rig, "cy", "720")), HasSubstr("c:6: cy: 720 is not within -0.5 to 719.5"));
  EXPECT_THAT(error_of(with(rig, "depth_cx", "-3e9")), HasSubstr("c:12: depth_cx"));
  EXPECT_THAT(error_of(with(rig, "k1", "1e20")), HasSubstr("c:14: k1 must be within -100 to 100"));
  EXPECT_THAT(error_of(with(rig, "depth_p2", "-101")), HasSubstr("depth_p2 must be within"));
  for (const char* value : {"0", "-1", "nan", "inf", "1e-300", "1e300", "99", "1e6"})
    EXPECT_THAT(error_of(with(rig, "depth_scale", value)), HasSubstr("c:7: depth_scale")) << value;
}

TEST(RigCalibration, AnotherSizeOfTheSameShapeIsScaled) {
  Intrinsics k;  // 640x480
  k.k1 = 0.2;
  const auto half = scaled_to(k, {320, 240});
  ASSERT_TRUE(half.ok());
  EXPECT_EQ(half->fx, 262.5);
  EXPECT_EQ(half->cx, 159.5);
  EXPECT_EQ(half->cy, 119.5);
  EXPECT_EQ(half->k1, 0.2);
  EXPECT_EQ(half->width, 320);
  EXPECT_THAT(scaled_to(k, {848, 480}).error().reason, HasSubstr("for 640x480, and 848x480 has another shape"));
}

}  // namespace
}  // namespace onemap::hal::imaging
