#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "hal/lens.hpp"
#include "mapping/local/voxel_map.hpp"
#include "support/analytic_scene.hpp"

namespace onemap::mapping {
namespace {

using test::look_at;
using test::RenderedFrame;
using test::Scene;

Scene room_with_sphere() {
  Scene scene;
  scene.spheres.push_back({Vector3d(0.1, 0.2, -0.3), 0.4});
  return scene;
}

std::vector<RenderedFrame> walk(const Scene& scene, const hal::Intrinsics& k, int frames) {
  const RayTable rays(k);
  std::vector<RenderedFrame> out;
  for (int i = 0; i < frames; ++i) {
    const double s = -0.8 + 1.6 * i / std::max(1, frames - 1);
    out.push_back(test::render(scene, k, rays, look_at({-1.2, s, 0.6 + 0.3 * s}, {0.4, 0.2 - 0.3 * s, -0.3})));
  }
  return out;
}

void fuse(VoxelMap& map, const std::vector<RenderedFrame>& frames) {
  const RayTable rays(frames.front().intrinsics);
  for (const RenderedFrame& frame : frames) map.integrate(frame.view(), rays, frame.T_world_camera);
}

// The equations as they stand, for one voxel: the range of distances that the 3 x 3 pixels around its image give (the
// look-up may round to a neighbour), and how many of them are within the truncation distance. Far readings on a plane
// are what the plane says, and as far as noise lets tell everything is one: less than half of it is allowed.
struct Expected {
  double low = 1e9, high = -1e9;
  int in_band = 0;
};
Expected expected(const RenderedFrame& frame, const Vector3d& p_map) {
  Expected out;
  const hal::Intrinsics& k = frame.intrinsics;
  const Vector3d p = frame.T_world_camera.inverse() * p_map;
  if (p[2] <= 0) return out;
  const hal::Point2 px = hal::pixel_of(k, {p[0] / p[2], p[1] / p[2]});
  for (int i = 0; i < 9; ++i) {
    const int u = static_cast<int>(std::floor(px.x + 0.5)) + i % 3 - 1,
              v = static_cast<int>(std::floor(px.y + 0.5)) + i / 3 - 1;
    if (u < 0 || v < 0 || u >= k.width || v >= k.height) continue;
    constexpr double kFar_m = 2, kNoise_m = 0.0017;  // at a metre
    const double depth_m = frame.depth[static_cast<std::size_t>(v * k.width + u)] / k.depth_scale, sdf = depth_m - p[2];
    if (std::abs(sdf) > 0.06) continue;
    ++out.in_band;
    const double off = 1 + (depth_m < kFar_m ? 0 : 0.4 * kNoise_m * depth_m * depth_m / 0.06 * kTsdfOne);
    out.low = std::min(out.low, sdf / 0.06 * kTsdfOne - off);
    out.high = std::max(out.high, sdf / 0.06 * kTsdfOne + off);
  }
  return out;
}

class Integrate : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Lens, Integrate, testing::Bool(),
                         [](const auto& lens) { return lens.param ? "Distorted" : "Pinhole"; });

TEST_P(Integrate, AgreesWithThePlainEquations) {
  const Scene scene = room_with_sphere();
  const auto frames = walk(scene, test::small_camera(GetParam()), 1);
  VoxelMap map{VoxelMapConfig{}};
  fuse(map, frames);
  int observed = 0, wrong_value = 0, wrong_absence = 0;
  map.for_each_sorted([&](const BlockView& block) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      const Vector3d index(8 * block.key.x + i % 8 + 0.5, 8 * block.key.y + i / 8 % 8 + 0.5,
                           8 * block.key.z + i / 64 + 0.5);
      const Voxel& voxel = block.voxels[static_cast<std::size_t>(i)];
      const Expected truth = expected(frames[0], index * 0.02);
      if (voxel.weight == 0) {
        wrong_absence += truth.in_band == 9;
      } else {
        ++observed;
        wrong_value += truth.in_band == 0 || voxel.tsdf() < truth.low || voxel.tsdf() > truth.high;
      }
    }
  });
  EXPECT_GT(observed, 50000);
  EXPECT_LT(wrong_value, observed / 500);  // where the resampled grid rounds by more than a pixel
  EXPECT_LT(wrong_absence, observed / 500);
}

TEST_P(Integrate, TouchesEveryBlockThatTheSurfaceCrosses) {
  const Scene scene = room_with_sphere();
  const auto frames = walk(scene, test::small_camera(GetParam()), 1);
  VoxelMap map{VoxelMapConfig{}};
  fuse(map, frames);
  const RayTable rays(frames[0].intrinsics);
  std::size_t missing = 0, blocks = 0;
  std::set<BlockKey> asked;
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) {
      const double z = frames[0].depth[static_cast<std::size_t>(v * 320 + u)] / 5000.0;
      if (z > 4) continue;
      const Vector3d ray(static_cast<double>(rays.row(v)[2 * u]), static_cast<double>(rays.row(v)[2 * u + 1]), 1);
      const Vector3d p = frames[0].T_world_camera * Vector3d(ray * z) / 0.16;
      const BlockKey key{static_cast<std::int32_t>(std::floor(p[0])), static_cast<std::int32_t>(std::floor(p[1])),
                         static_cast<std::int32_t>(std::floor(p[2]))};
      if (!asked.insert(key).second) continue;
      ++blocks;
      missing += map.find(key) == nullptr;
    }
  EXPECT_GT(blocks, 300u);
  EXPECT_LE(missing, blocks / 100);  // only corners that fall between two of the subsampled rays
}

TEST(IntegrateOrder, DoesNotMatter) {
  auto frames = walk(room_with_sphere(), test::small_camera(), 8);
  VoxelMap forward{VoxelMapConfig{}}, backward{VoxelMapConfig{}};
  fuse(forward, frames);
  std::reverse(frames.begin(), frames.end());
  fuse(backward, frames);
  EXPECT_EQ(forward.digest(), backward.digest());
  EXPECT_GT(forward.used(), 500u);
}

// Saturated sums and colours, no colours, a lens with distortion: the twins fuse the same bytes.
TEST(IntegrateTwins, FuseTheSameBytes) {
  for (const bool distorted : {false, true}) {
    const auto frames = walk(room_with_sphere(), test::small_camera(distorted), 12);
    const RayTable rays(frames.front().intrinsics);
    VoxelMapConfig config;
    config.simd = false;
    VoxelMap plain(config);
    config.simd = true;
    VoxelMap simd(config);
    const auto nearly_fill = [](VoxelMap& map) {
      std::vector<BlockKey> keys;
      map.for_each([&](const BlockView& block) { keys.push_back(block.key); });
      for (const BlockKey& key : keys) {
        Voxel* voxels = map.find_or_add(key);
        for (int i = 0; i < kBlockVoxels; ++i)
          if (voxels[i].weight > 0) voxels[i].add_tsdf(-500, 4000), voxels[i].add_tsdf(-500, 4000);
      }
    };
    for (int round = 0; round < 30; ++round) {
      if (round == 1) nearly_fill(plain), nearly_fill(simd);
      for (const RenderedFrame& frame : frames) {
        hal::FrameView view = frame.view();
        if (round % 4 == 3) view.rgb = {};
        for (VoxelMap* map : {&plain, &simd}) map->integrate(view, rays, frame.T_world_camera);
      }
    }
    std::size_t full = 0, colours = 0;
    plain.for_each([&](const BlockView& block) {
      for (const Voxel& voxel : block.voxels) {
        full += voxel.weight > 4000 && voxel.weight < 8000;  // what was nearly full was halved
        colours += voxel.color_weight > Voxel::kMaxColorWeight / 2;
      }
    });
    EXPECT_GT(full, 1000u);
    EXPECT_GT(colours, 1000u);
    EXPECT_EQ(plain.digest(), simd.digest());
  }
}

TEST(IntegrateFull, KeepsWhatItHasAndCounts) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 3);
  VoxelMapConfig config;
  config.image_pixels = 320 * 240;
  config.budget_bytes = PinholeView::bytes_for(config.image_pixels) + 100 * 6200;
  VoxelMap map(config);
  fuse(map, frames);
  EXPECT_EQ(map.used(), map.capacity());
  EXPECT_GT(map.counters().blocks_refused, 0u);
  EXPECT_LE(map.bytes(), config.budget_bytes);
  EXPECT_EQ(map.counters().integrated_frames, 3u);
}

// The same image again and again: a full map misses the same blocks, each counted once a frame.
TEST(IntegrateFull, CountsTheBlocksThatAreMissingAndTheirFrames) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 1);
  VoxelMap whole{VoxelMapConfig{}};
  fuse(whole, frames);
  VoxelMapConfig config;
  config.image_pixels = 320 * 240;
  while (VoxelMap::capacity_of(config) > 200) config.budget_bytes -= 6200;
  VoxelMap map(config);
  for (std::uint64_t n = 1; n <= 3; ++n) {
    fuse(map, frames);
    EXPECT_EQ(map.counters().blocks_refused, n * (whole.used() - map.capacity()));
    EXPECT_EQ(map.counters().frames_short, n);
  }
  EXPECT_EQ(whole.counters().frames_short, 0u);
}

TEST(IntegratePose, RefusesWhatIsNotFinite) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 1);
  const RayTable rays(frames[0].intrinsics);
  VoxelMap map{VoxelMapConfig{}};
  Pose pose;
  pose.t[1] = std::numeric_limits<double>::quiet_NaN();
  map.integrate(frames[0].view(), rays, pose);
  pose = {};
  pose.R(0, 0) = std::numeric_limits<double>::infinity();
  map.integrate(frames[0].view(), rays, pose);
  EXPECT_EQ(map.counters().frames_refused, 2u);
  EXPECT_EQ(map.used(), 0u);
}

TEST(IntegrateSettled, HandsOutBlocksThatAreNoLongerSeen) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 1);
  const RayTable rays(frames[0].intrinsics);
  VoxelMap map{VoxelMapConfig{}};
  const Pose& seen = frames[0].T_world_camera;
  Pose away = seen;
  away.t[0] += 100;
  map.integrate(frames[0].view(), rays, seen);
  std::size_t blocks = 0;  // with something in them
  map.for_each_sorted([&](const BlockView& block) {
    blocks += std::any_of(block.voxels.begin(), block.voxels.end(), [](const Voxel& v) { return v.weight > 0; });
  });
  EXPECT_TRUE(map.take_settled(1, 100000).empty());
  map.integrate(frames[0].view(), rays, away);
  EXPECT_EQ(map.take_settled(2, 100000).size(), 0u);
  EXPECT_EQ(map.take_settled(1, 100000).size(), blocks);
  EXPECT_GT(blocks, 400u);
}

TEST(IntegrateRange, IgnoresWhatIsTooFar) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 1);
  VoxelMapConfig config;
  config.max_depth_m = 0.5f;
  VoxelMap map(config);
  fuse(map, frames);
  EXPECT_EQ(map.used(), 0u);
}

// The band of a map to be shown has colour throughout, the usual one two voxels before and behind the surface.
TEST(IntegrateColour, ReachesThroughABandOfMoreThanThreeVoxels) {
  const auto frames = walk(room_with_sphere(), test::small_camera(), 1);
  for (const float voxel_m : {0.02f, 0.01f}) {
    VoxelMapConfig config;
    config.voxel_m = voxel_m;
    config.budget_bytes = 128u << 20;
    VoxelMap map(config);
    fuse(map, frames);
    int observed = 0, uncoloured = 0, near = 0;
    map.for_each([&](const BlockView& block) {
      for (const Voxel& voxel : block.voxels) {
        if (voxel.weight == 0) continue;
        ++observed;
        uncoloured += voxel.color_weight == 0;
        near += voxel.color_weight == 0 && std::abs(voxel.tsdf()) < 660;
      }
    });
    EXPECT_GT(observed, 50000);
    EXPECT_EQ(near, 0) << voxel_m;
    if (voxel_m > 0.015f)
      EXPECT_GT(uncoloured, observed / 5);
    else
      EXPECT_EQ(uncoloured, 0);
  }
}

// A truncation that is deeper than the depth: nothing behind the camera was seen.
TEST(IntegrateRange, TakesNothingBehindTheCamera) {
  hal::Intrinsics k = test::small_camera();
  k.cx = 160;  // the axis falls on a column and a row of voxels
  k.cy = 120;
  RenderedFrame frame{k, {}, std::vector<std::uint16_t>(320 * 240, 2500), {}};  // a wall at 0.5 m
  VoxelMapConfig config;
  config.truncation_m = 2;
  VoxelMap map(config);
  frame.T_world_camera.t = Vector3d(0.01, 0.01, 0);
  map.integrate(frame.view(), RayTable(k), frame.T_world_camera);
  int behind = 0, in_front = 0;
  map.for_each_sorted([&](const BlockView& block) {
    EXPECT_GE(block.key.z, 0);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const bool before = 8 * block.key.z + static_cast<int>(i / 64) < 0;
      (before ? behind : in_front) += block.voxels[i].weight > 0;
    }
  });
  EXPECT_EQ(behind, 0);
  EXPECT_GT(in_front, 1000);
}

// A block that reaches from before the camera to behind it, seen along the optical axis.
TEST(IntegrateRange, FusesNoVoxelBehindTheCamera) {
  hal::Intrinsics k = test::small_camera();
  RenderedFrame frame{k, {}, std::vector<std::uint16_t>(320 * 240, 2500), {}};
  VoxelMapConfig config;
  config.truncation_m = 2;
  VoxelMap map(config);
  frame.T_world_camera.t = Vector3d(0.01, 0.01, 0.09);
  map.integrate(frame.view(), RayTable(k), frame.T_world_camera);
  const Voxel* block = map.find({0, 0, 0});
  ASSERT_NE(block, nullptr);
  EXPECT_GT(block[7 * 64].weight, 0) << "6 cm in front";
  EXPECT_EQ(block[0].weight, 0) << "8 cm behind, on the axis";
}

}  // namespace
}  // namespace onemap::mapping
