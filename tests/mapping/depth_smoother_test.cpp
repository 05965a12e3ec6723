// What fusion sees of a depth image: far readings on a plane are smoothed, all others are as they were measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "mapping/local/depth_smoother.hpp"
#include "mapping/local/pinhole_view.hpp"
#include "mapping/local/surface.hpp"
#include "mapping/local/voxel_map.hpp"
#include "support/analytic_scene.hpp"
#include "support/random.hpp"

namespace onemap::mapping {
namespace {

struct Smoothed {
  hal::Intrinsics intrinsics = test::small_camera(false);
  std::vector<std::uint16_t> depth;
  std::vector<float> view_m;

  float read_m(int u, int v) const {
    return static_cast<float>(depth[static_cast<std::size_t>(v * intrinsics.width + u)]) *
           static_cast<float>(1.0 / intrinsics.depth_scale);
  }
  float view_at_m(int u, int v) const {
    return view_m[static_cast<std::size_t>((v + 1) * (intrinsics.width + 2) + u + 1)];
  }
  hal::FrameView frame() const { return {{}, {}, 0, &intrinsics, {}, depth}; }
};

// Of what stands at inverse_depth(u, v) (1/m; 0: no reading), measured with the noise of a Kinect.
Smoothed measured(const std::function<double(int, int)>& inverse_depth) {
  Smoothed out;
  const hal::Intrinsics& k = out.intrinsics;
  test::Random random(7);
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const double steps = std::floor(348 * inverse_depth(u, v) + random.normal(0.5) + 0.5);
      const double z_m = inverse_depth(u, v) > 0 && steps > 0 ? 348 / steps : 0;
      out.depth.push_back(static_cast<std::uint16_t>(std::lround(z_m * k.depth_scale)));
    }
  PinholeView view(out.depth.size());
  view.load(out.frame(), RayTable(k), 6.f);
  out.view_m.assign(view.depth_m(), view.depth_m() + view.width() * view.height());
  return out;
}

// The share of readings in columns [from, to) that are as they were measured.
double share_as_measured(const Smoothed& seen, int from, int to) {
  int all = 0, same = 0;
  for (int v = 0; v < seen.intrinsics.height; ++v)
    for (int u = from; u < to; ++u, ++all) same += seen.view_at_m(u, v) == seen.read_m(u, v);
  return static_cast<double>(same) / all;
}

TEST(DepthSmoother, FarPlanesAreSmooth) {
  const auto plane = [](int u, int v) { return 0.28 + 0.0003 * u - 0.0002 * v; };
  const Smoothed seen = measured(plane);
  double before = 0, after = 0;
  for (int v = 2; v + 2 < seen.intrinsics.height; ++v)
    for (int u = 2; u + 2 < seen.intrinsics.width; ++u) {
      const double z_m = 1 / plane(u, v);
      before += std::pow(static_cast<double>(seen.read_m(u, v)) - z_m, 2);
      after += std::pow(static_cast<double>(seen.view_at_m(u, v)) - z_m, 2);
    }
  EXPECT_LT(std::sqrt(after), 0.35 * std::sqrt(before));
}

// Also on a plane that goes on to where they are far.
TEST(DepthSmoother, NearReadingsAreAsMeasured) {
  const Smoothed seen = measured([](int u, int) { return 0.42 + 0.002 * u; });
  int near = 0, far = 0, smooth = 0;
  for (int v = 0; v < seen.intrinsics.height; ++v)
    for (int u = 0; u < seen.intrinsics.width; ++u) {
      const bool same = seen.view_at_m(u, v) == seen.read_m(u, v);
      if (seen.read_m(u, v) < 2) {
        ++near;
        EXPECT_TRUE(same) << u << ' ' << v;
      } else {
        ++far;
        smooth += same ? 0 : 1;
      }
    }
  EXPECT_GT(near, 1000);
  EXPECT_GT(smooth, far / 2);
}

TEST(DepthSmoother, EdgesAndThinThingsStay) {
  constexpr int kEdge = 40, kBar = 80;  // 30 cm lie between the wall at 3.3 m and what is before it
  const Smoothed seen =
      measured([](int u, int) { return u < kEdge || u == kBar || u == kBar + 1 ? 1 / 3.0 : 1 / 3.3; });
  EXPECT_GT(share_as_measured(seen, kEdge - 2, kEdge + 2), 0.99);
  EXPECT_GT(share_as_measured(seen, kBar - 2, kBar + 4), 0.99);
  EXPECT_LT(share_as_measured(seen, kEdge + 4, kBar - 4), 0.2) << "the wall between them is smooth";
}

TEST(DepthSmoother, BesideHolesReadingsAreAsMeasured) {
  constexpr int kHole = 60;
  const Smoothed seen = measured([](int u, int) { return u == kHole ? 0 : 0.3; });
  EXPECT_EQ(share_as_measured(seen, kHole - 2, kHole + 3), 1);
}

TEST(DepthSmoother, BothTwinsGiveTheSameBytes) {
  constexpr int kWidth = 150, kHeight = 90;
  test::Random random(3);
  std::vector<float> plain;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const bool hole = random.below(200) == 0;
    plain.push_back(0.001f * static_cast<float>(hole ? random.below(5000) : 2900 + random.below(40)));
  }
  std::vector<float> simd = plain;
  const std::vector<float> before = plain;
  DepthSmoother smoother(kHeight);
  smoother.smooth(plain.data(), kWidth, kHeight, false);
  smoother.smooth(simd.data(), kWidth, kHeight, true);
  EXPECT_EQ(plain, simd);
  int changed = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) changed += plain[i] != before[i];
  EXPECT_GT(changed, 2000);
}

// The image is gone through in strips, which nobody sees.
TEST(DepthSmoother, AnImageThatIsShiftedIsSmoothedAsWell) {
  constexpr int kWidth = 300, kHeight = 40, kShift = 7, kMargin = 5;
  test::Random random(11);
  std::vector<float> whole, shifted;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      whole.push_back(static_cast<float>(3 + random.normal(0.012)));
      if (x >= kShift) shifted.push_back(whole.back());
    }
  const std::vector<float> before = whole;
  DepthSmoother smoother(kHeight);
  smoother.smooth(whole.data(), kWidth, kHeight);
  smoother.smooth(shifted.data(), kWidth - kShift, kHeight);
  std::size_t smooth = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = kMargin; x < kWidth - kShift - kMargin; ++x) {
      const auto at = static_cast<std::size_t>(y * kWidth + x + kShift);
      EXPECT_EQ(shifted[static_cast<std::size_t>(y * (kWidth - kShift) + x)], whole[at]) << x << ' ' << y;
      smooth += whole[at] != before[at] ? 1 : 0;
    }
  EXPECT_GT(smooth, before.size() / 2);
}

TEST(DepthSmoother, AFarWallIsSurfaceOnceSeen) {
  const Smoothed seen = measured([](int, int) { return 1 / 3.7; });
  VoxelMap map{VoxelMapConfig{}};
  map.integrate(seen.frame(), RayTable(seen.intrinsics), Pose{});
  EXPECT_GT(extract_mesh(map).triangles.size(), 1000u);
}

}  // namespace
}  // namespace onemap::mapping
