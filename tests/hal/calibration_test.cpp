#include "hal/imaging/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::hal::imaging {
namespace {

using testing::HasSubstr;

TEST(CalibrationFile, ReadsEveryKey) {
  Calibration calibration;
  const char* text =
      "# Kinect\nfx 1\nfy 2.5\r\ncx 3\ncy 4e0\nk1 5\nk2 -6\np1 7\np2 8\nk3 9\n\ndepth_scale 1000 # millimetres\n";
  const Status parsed = calibration.parse(text, "c");
  ASSERT_TRUE(parsed.ok()) << parsed.error().text();
  Intrinsics k;
  k.width = 77;
  ASSERT_TRUE(calibration.apply(k).ok());
  const double values[] = {k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2, k.k3, k.depth_scale};
  EXPECT_THAT(values, testing::ElementsAre(1, 2.5, 3, 4, 5, -6, 7, 8, 9, 1000));
  EXPECT_EQ(k.width, 77);
}

TEST(CalibrationFile, ErrorsCarryFileAndLine) {
  const std::pair<const char*, const char*> cases[] = {{"fx 1\nfz 2", "c:2: unknown key 'fz'"},
                                                       {"fx one", "c:1: fx: 'one' is not a number"},
                                                       {"fx nan", "c:1: fx: 'nan'"},
                                                       {"fx 1e999", "c:1: fx: '1e999'"},
                                                       {"#\n#\nfx", "c:3: 1 words"},
                                                       {"fx 1 2", "c:1: 3 words"},
                                                       {"fx 1\nfx 1", "c:2: fx was given in line 1"},
                                                       {"fx inf", "c:1: fx: 'inf'"},
                                                       {"fx 1e300", "c:1: fx: 1e300 is not within 1 to"},
                                                       {"fy 0", "c:1: fy: 0 is not within 1 to"},
                                                       {"fx -525", "c:1: fx: -525 is not within"},
                                                       {"cx -1", "c:1: cx: -1 is not within"},
                                                       {"cy 1e9", "c:1: cy: 1e9 is not within"},
                                                       {"k1 101", "c:1: k1: 101 is not within -100 to 100"},
                                                       {"p2 -1e300", "c:1: p2: -1e300 is not within"},
                                                       {"k3 nan", "c:1: k3: 'nan'"},
                                                       {"depth_scale 0", "c:1: depth_scale: 0 is not within 100 to"},
                                                       {"depth_scale -1", "c:1: depth_scale: -1 is not within"},
                                                       {"noise_least_m 0", "c:1: noise_least_m: 0 is not within"},
                                                       {"noise_growth_per_m -1", "noise_growth_per_m: -1 is not"},
                                                       {"noise_best_m nan", "c:1: noise_best_m: 'nan'"}};
  for (const auto& [text, expected] : cases) {
    Calibration calibration;
    const Status status = calibration.parse(text, "c");
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_THAT(status.error().text(), HasSubstr(expected));
  }
}

TEST(CalibrationFile, TheNoiseOfDepthNeedsNoLens) {
  Calibration calibration;
  EXPECT_EQ(calibration.noise(), DepthNoise{});
  ASSERT_TRUE(calibration.parse("noise_growth_per_m 0.004\nnoise_best_m 0.2", "c").ok());
  EXPECT_EQ(calibration.noise(), (DepthNoise{0.0012, 0.004, 0.2}));
  EXPECT_FALSE(calibration.has_lens());
  ASSERT_TRUE(calibration.parse("fx 500\nnoise_least_m 0.002", "d").ok());
  EXPECT_EQ(calibration.noise(), (DepthNoise{0.002, 0.004, 0.2}));
  EXPECT_TRUE(calibration.has_lens());
}

TEST(CalibrationFile, NamesWhatIsMissing) {
  Calibration calibration;
  ASSERT_TRUE(calibration.parse("fx 1\ncx 2\nk1 3", "c").ok());
  Intrinsics k;
  const Status status = calibration.apply(k);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().reason, "the calibration lacks fy cy");
}

}  // namespace
}  // namespace onemap::hal::imaging
