// The resampler's bytes beside those of a slow and plain one: on random submaps and on real ones, in both twins.
#include <gtest/gtest.h>

#include "mapping/team/atlas.hpp"
#include "support/analytic_scene.hpp"
#include "support/random.hpp"
#include "support/slow_resample.hpp"

namespace onemap::mapping {
namespace {

struct Case {
  const char* name;
  QuantizedPose pose;
  std::int32_t source_um = 20000, truncation_um = 60000;
};

QuantizedPose turned(double wx, double wy, double wz, double x, double y, double z) {
  Vector6d v;
  v << wx, wy, wz, x, y, z;
  return quantize(small_motion(v));
}

const double kQuarter = 1.5707963267948966;

const std::vector<Case> kCases{
    {"here", {}},
    {"moved by voxels", turned(0, 0, 0, 0.4, -0.06, 1.02)},
    {"moved by parts", turned(0, 0, 0, 0.013, -0.057, 1.0011)},
    {"turned a quarter", turned(0, 0, kQuarter, 0.02, 0, -0.3)},
    {"turned about x", turned(0.6, 0, 0, 1, 2, 3)},  // the map's x is the source's
    {"turned a little", turned(0.0004, -0.0003, 0.0002, -3, 1, 0.5)},
    {"turned", turned(0.3, -0.8, 1.1, 12.3, -45.6, 7.8)},
    {"turned, far away", turned(-2.1, 0.4, 0.9, 5000, -9000, 70)},
    {"coarser source", turned(0.3, 0.2, 0.1, 1, 1, 1), 80000, 160000},
    {"finer source", turned(0.3, 0.2, -0.1, 1, 1, 1), 5000, 60000},
    {"other truncation", turned(-0.3, 0.2, -0.1, 1, 1, 1), 25000, 90000},
};

// Voxels of which a share is observed, some without colour; smooth enough that most cells lie on one surface.
std::vector<SubmapBlock> random_blocks(test::Random& random, std::uint64_t percent) {
  std::vector<SubmapBlock> out;
  for (std::int32_t x = -2; x < 1; ++x)
    for (std::int32_t y = 0; y < 2; ++y)
      for (std::int32_t z = -1; z < 1; ++z) {
        if (random.next() % 5 == 0) continue;
        SubmapBlock& block = out.emplace_back(SubmapBlock{{x, y, z}, {}});
        for (SubmapVoxel& voxel : block.voxels) {
          if (random.next() % 100 >= percent) continue;
          voxel.tsdf = static_cast<std::int16_t>(
              static_cast<int>(random.next() % (random.next() % 9 == 0 ? 2001 : 1401)) - 1000);
          voxel.weight = static_cast<std::uint8_t>(1 + random.next() % 255);
          if (random.next() % 10 == 0) continue;
          for (std::uint8_t& c : voxel.rgb) c = static_cast<std::uint8_t>(random.next() % 256);
        }
      }
  return out;
}

std::vector<AtlasBlock> listed(const std::vector<SubmapBlock>& blocks, const Case& c) {
  std::vector<AtlasBlock> out;
  for (const SubmapBlock& block : blocks) out.push_back({c.source_um, c.truncation_um, 0, &block});
  return out;
}

VoxelMap empty_map(std::size_t most_blocks = 4000) {
  VoxelMapConfig config;
  config.image_pixels = 0;
  config.resident = false;
  config.most_blocks = most_blocks;
  return VoxelMap(config);
}

struct Remains {
  std::uint64_t digest = 0, refused = 0;
  std::size_t blocks = 0;
  bool exact = true;
  bool operator==(const Remains&) const = default;
};

void PrintTo(const Remains& o, std::ostream* out) {
  *out << std::hex << o.digest << std::dec << ", " << o.refused << " refused, " << o.blocks << " blocks, exact "
       << o.exact;
}

Remains remains_of(const VoxelMap& map, bool exact) {
  return {map.digest(), map.counters().blocks_refused, map.used(), exact};
}

// What is left after fusing twice and taking back once.
Remains fuse(const std::vector<SubmapBlock>& blocks, const Case& c, std::size_t most_blocks, bool simd) {
  VoxelMap map = empty_map(most_blocks);
  const std::vector<AtlasBlock> list = listed(blocks, c);
  bool exact = fuse_submap(list, c.pose, Fusing::add, map, nullptr, simd);
  exact = fuse_submap(list, c.pose, Fusing::add, map, nullptr, simd) && exact;
  exact = fuse_submap(list, c.pose, Fusing::take_back, map, nullptr, simd) && exact;
  return remains_of(map, exact);
}

Remains fuse_slowly(const std::vector<SubmapBlock>& blocks, const Case& c, std::size_t most_blocks) {
  VoxelMap map = empty_map(most_blocks);
  test::SlowResampler slow(blocks, c.source_um, c.truncation_um, c.pose, map);
  bool exact = slow.fuse(Fusing::add);
  exact = slow.fuse(Fusing::add) && exact;
  exact = slow.fuse(Fusing::take_back) && exact;
  return remains_of(map, exact);
}

void expect_equal(const std::vector<SubmapBlock>& blocks, const Case& c, std::size_t most_blocks = 4000) {
  const Remains slow = fuse_slowly(blocks, c, most_blocks);
  EXPECT_GT(slow.blocks, 0u) << c.name;
  EXPECT_EQ(fuse(blocks, c, most_blocks, false), slow) << c.name << ", plain";
  EXPECT_EQ(fuse(blocks, c, most_blocks, true), slow) << c.name << ", simd";
}

TEST(Resample, RandomSubmapsGiveTheBytesOfTheSlowOne) {
  test::Random random(11);
  for (const std::uint64_t percent : {60, 97, 100})
    for (const Case& c : kCases) expect_equal(random_blocks(random, percent), c);
}

TEST(Resample, AFullMapRefusesWhatTheSlowOneRefuses) {
  test::Random random(12);
  for (const Case& c : kCases) {
    const auto blocks = random_blocks(random, 98);
    const std::size_t needed = fuse_slowly(blocks, c, 4000).blocks;
    ASSERT_GT(needed, 1u);
    EXPECT_GT(fuse_slowly(blocks, c, needed / 2).refused, 0u);
    expect_equal(blocks, c, needed / 2);
  }
}

TEST(Resample, SaturationIsReachedWhereTheSlowOneReachesIt) {
  std::vector<SubmapBlock> blocks{{{0, 0, 0}, {}}};
  for (SubmapVoxel& voxel : blocks[0].voxels) voxel = {-700, 255, {255, 255, 255}};
  const Case& c = kCases[6];
  const std::vector<AtlasBlock> list = listed(blocks, c);
  VoxelMap fast = empty_map(), slow = empty_map();
  test::SlowResampler reference(blocks, c.source_um, c.truncation_um, c.pose, slow);
  int first = 0;
  for (int i = 1; i <= 300; ++i) {
    const bool exact = fuse_submap(list, c.pose, Fusing::add, fast);
    ASSERT_EQ(exact, reference.fuse(Fusing::add)) << i;
    if (!exact && first == 0) first = i;
  }
  EXPECT_EQ(first, Voxel::kMaxWeight / 255 + 1);
  EXPECT_EQ(fast.digest(), slow.digest());
}

TEST(Resample, RealSubmapsGiveTheBytesOfTheSlowOne) {
  test::Scene scene;
  scene.spheres.push_back({Vector3d(0.1, 0.2, -0.3), 0.4});
  const auto k = test::small_camera();
  const RayTable rays(k);
  VoxelMap local{VoxelMapConfig{}};
  for (int i = 0; i < 2; ++i) {
    const auto frame = test::render(scene, k, rays, test::look_at({-1.2, 0.3 * i, 0.6}, {0.4, 0.2, -0.3}));
    local.integrate(frame.view(), rays, frame.T_world_camera);
  }
  const std::vector<SubmapBlock> blocks = make_submap(local, local.take_settled(0, 300)).blocks;
  ASSERT_GT(blocks.size(), 100u);
  for (const Case& c : kCases)
    if (c.source_um == 20000) expect_equal(blocks, c);
}

}  // namespace
}  // namespace onemap::mapping
