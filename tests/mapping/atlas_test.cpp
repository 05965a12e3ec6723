#include "mapping/team/atlas.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/local/surface.hpp"
#include "support/analytic_scene.hpp"
#include "support/random.hpp"
#include "support/voxel_error.hpp"

namespace onemap::mapping {
namespace {

using test::look_at;
using test::Scene;

Scene room_with_sphere() {
  Scene scene;
  scene.spheres.push_back({Vector3d(0.1, 0.2, -0.3), 0.4});
  return scene;
}

// What a robot maps whose own frame lies at T_world_robot while it looks at the room from `side`.
VoxelMap explore(const Pose& T_world_robot, double side, float voxel_m = 0.02f, float truncation_m = 0.06f) {
  static const Scene scene = room_with_sphere();
  const auto k = test::small_camera();
  const RayTable rays(k);
  VoxelMapConfig config;
  config.voxel_m = voxel_m;
  config.truncation_m = truncation_m;
  VoxelMap map(config);
  for (int i = 0; i < 4; ++i) {
    const double s = side + 0.15 * i;
    const auto frame = test::render(scene, k, rays, look_at({-1.2, s, 0.6}, {0.4, 0.2 - 0.3 * s, -0.3}));
    map.integrate(frame.view(), rays, T_world_robot.inverse() * frame.T_world_camera);
  }
  return map;
}

std::vector<SubmapRecord> all_submaps(VoxelMap& map, std::size_t blocks_each = 100) {
  std::vector<SubmapRecord> out;
  for (auto keys = map.take_settled(0, blocks_each); !keys.empty(); keys = map.take_settled(0, blocks_each))
    out.push_back(make_submap(map, keys));
  return out;
}

// Blocks with something in them; a ray may pass a block without a voxel centre in its band.
std::size_t filled_blocks(const VoxelMap& map) {
  std::size_t out = 0;
  map.for_each_sorted([&](const BlockView& block) {
    out += std::any_of(block.voxels.begin(), block.voxels.end(), [](const Voxel& v) { return v.weight > 0; });
  });
  return out;
}

// One robot's submaps with one anchor, the keyframe 0.
struct Source {
  Source(const std::vector<SubmapRecord>& records, const Pose& pose = {}) : T_map_anchor(quantize(pose)) {
    for (std::size_t i = 0; i < records.size(); ++i) submaps.push_back({static_cast<std::uint32_t>(i), &records[i]});
  }
  Atlas::Placed placed() const { return {T_map_anchor, submaps}; }
  void add_to(Atlas& atlas) const { atlas.add(placed()); }
  QuantizedPose T_map_anchor;
  std::vector<Atlas::Submap> submaps;
};

Pose motion(double wx, double wy, double wz, double x, double y, double z) {
  Vector6d v;
  v << wx, wy, wz, x, y, z;
  return small_motion(v);
}

struct Error {
  double mean_m = 0, far_share = 0;  // far: more than two centimetres
  std::size_t vertices = 0;
};
Error surface_error(const VoxelMap& map, const Pose& T_world_global) {
  const Scene scene = room_with_sphere();
  const TriangleMesh mesh = extract_mesh(map, 1);
  Error out;
  out.vertices = mesh.vertices.size();
  for (const auto& v : mesh.vertices) {
    const double d = scene.distance(T_world_global * Vector3d(v.cast<double>()));
    out.mean_m += d / static_cast<double>(out.vertices);
    out.far_share += (d > 0.02 ? 1.0 : 0.0) / static_cast<double>(out.vertices);
  }
  return out;
}

TEST(Atlas, IdentityReproducesEveryVoxel) {
  VoxelMap local = explore({}, -0.6);
  const auto records = all_submaps(local);
  Atlas atlas({});
  Source(records).add_to(atlas);
  std::size_t observed = 0, found = 0;
  local.for_each_sorted([&](const BlockView& block) {
    const Voxel* global = atlas.map().find(block.key);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const Voxel& voxel = block.voxels[i];
      if (voxel.weight == 0) continue;
      ++observed;
      ASSERT_NE(global, nullptr);
      EXPECT_EQ(global[i].tsdf(), voxel.tsdf());
      EXPECT_EQ(global[i].weight, std::min<int>(voxel.weight, 255));
      EXPECT_EQ(global[i].color(), voxel.color());
    }
  });
  atlas.map().for_each_sorted([&](const BlockView& block) {
    for (const Voxel& voxel : block.voxels) found += voxel.weight > 0;
  });
  EXPECT_GT(observed, 50000u);
  EXPECT_EQ(found, observed);
  EXPECT_EQ(atlas.counters().blocks, filled_blocks(local));
}

TEST(Atlas, OrderOfSubmapsDoesNotMatter) {
  const Pose T_world_b = motion(0.2, -0.1, 0.4, 0.5, -0.3, 0.2);
  VoxelMap a = explore({}, -0.6), b = explore(T_world_b, 0.1);
  const auto ra = all_submaps(a), rb = all_submaps(b);
  Source from_a(ra), from_b(rb, T_world_b);
  Atlas atlas({});
  from_a.add_to(atlas);
  from_b.add_to(atlas);
  const std::uint64_t digest = atlas.map().digest();
  test::Random random(9);
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = from_b.submaps.size(); k > 1; --k)
      std::swap(from_b.submaps[k - 1], from_b.submaps[random.next() % k]);
    atlas.clear();  // a used atlas forgets what it held
    from_a.add_to(atlas);
    from_b.add_to(atlas);
    EXPECT_EQ(atlas.map().digest(), digest);
  }
}

// Two robots with frames far from each other in angle and place, one with coarser voxels: one surface, at the truth.
TEST(Atlas, MovedAndResampledRobotsLieOnTheTruth) {
  const Pose T_world_b = motion(0.7, -0.4, 1.1, 0.5, -0.3, 0.2), T_world_c = motion(-0.3, 0.8, -0.2, -2, 1, 0.1);
  VoxelMap a = explore({}, -0.6), b = explore(T_world_b, -0.3), c = explore(T_world_c, 0.0, 0.025f, 0.075f);
  const auto ra = all_submaps(a), rb = all_submaps(b), rc = all_submaps(c);
  const Source from_a(ra), from_b(rb, T_world_b), from_c(rc, T_world_c);
  Atlas atlas({});
  for (const Source* source : {&from_a, &from_b, &from_c}) source->add_to(atlas);
  const Error alone = surface_error(a, {}), all = surface_error(atlas.map(), {});
  EXPECT_LT(all.mean_m, 0.15 * 0.02) << "mean error in voxels: " << all.mean_m / 0.02;
  EXPECT_LT(all.far_share, 0.005);
  EXPECT_GT(all.vertices, alone.vertices);
  // A doubled surface would double the vertices of what all three see.
  EXPECT_LT(all.vertices, 1.5 * static_cast<double>(alone.vertices));

  // Each robot alone keeps most of its surface when it is moved.
  for (const Source* source : {&from_b, &from_c}) {
    Atlas one({});
    source->add_to(one);
    const Error moved = surface_error(one.map(), {});
    EXPECT_LT(moved.mean_m, 0.15 * 0.02);
    EXPECT_GT(static_cast<double>(moved.vertices), 0.85 * static_cast<double>(alone.vertices));
  }
}

SubmapRecord one_voxel(std::int16_t tsdf, std::int32_t voxel_um = 20000) {
  SubmapRecord out{0, voxel_um, 3 * voxel_um, {{{1, 2, 3}, {}}}};
  out.blocks[0].voxels[77] = {tsdf, 5, {10, 20, 30}};
  return out;
}

TEST(Atlas, LaterVersionReplacesTheEarlier) {
  const SubmapRecord old = one_voxel(100), now = one_voxel(-300);
  const std::vector<Atlas::Submap> submaps{{4, &now}, {3, &old}};
  Atlas atlas({});
  atlas.add({{}, submaps});
  const Voxel* block = atlas.map().find({1, 2, 3});
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block[77].tsdf(), -300);
  EXPECT_EQ(block[77].weight, 5);
  EXPECT_EQ(block[77].color(), (Rgb{10, 20, 30}));
  EXPECT_EQ(atlas.counters().blocks, 1u);
}

struct Taken : testing::Test {
  const Pose T_world_b = motion(0.2, -0.1, 0.4, 0.5, -0.3, 0.2);
  VoxelMap a = explore({}, -0.6), b = explore(T_world_b, 0.1);
  const std::vector<SubmapRecord> ra = all_submaps(a), rb = all_submaps(b);
  const Source from_a{ra}, from_b{rb, T_world_b};
};

TEST_F(Taken, WhatIsTakenAwayWasNeverThere) {
  Atlas atlas({}), alone({});
  from_a.add_to(alone);
  from_a.add_to(atlas);
  from_b.add_to(atlas);
  EXPECT_NE(atlas.map().digest(), alone.map().digest());
  atlas.replace(from_b.placed(), {});
  atlas.settle();
  EXPECT_EQ(atlas.map().digest(), alone.map().digest());
  EXPECT_EQ(atlas.map().used(), alone.map().used());
  EXPECT_EQ(atlas.counters().blocks, alone.counters().blocks);
  EXPECT_TRUE(atlas.exact());
}

// Or after each peak of what is under way every page would hold a part of a block.
TEST_F(Taken, WhatIsLeftLiesTogether) {
  Atlas atlas({}), alone({});
  from_a.add_to(alone);
  alone.settle();
  from_b.add_to(atlas);
  from_a.add_to(atlas);
  atlas.replace(from_b.placed(), {});
  atlas.settle();
  EXPECT_EQ(atlas.map().digest(), alone.map().digest());
  std::vector<const Voxel*> where;
  atlas.map().for_each([&](const BlockView& block) { where.push_back(block.voxels.data()); });
  std::ranges::sort(where);
  ASSERT_GT(where.size(), 100u);
  for (std::size_t i = 1; i < where.size(); ++i) ASSERT_EQ(where[i] - where[i - 1], kBlockVoxels) << i;
}

TEST_F(Taken, WhatMovedIsWhereItWouldBe) {
  const Source moved(rb, motion(0.21, -0.1, 0.4, 0.55, -0.3, 0.2));
  Atlas atlas({}), direct({});
  for (const Source* source : {&from_a, &moved}) source->add_to(direct);
  for (const Source* source : {&from_b, &from_a}) source->add_to(atlas);
  atlas.replace(from_b.placed(), moved.placed());
  atlas.settle();
  EXPECT_EQ(atlas.map().digest(), direct.map().digest());
}

// A submap that comes in pieces, some blocks of it in newer versions: only what differs is fused, to the same bytes.
TEST_F(Taken, WhatGrewIsAsIfItHadComeAtOnce) {
  std::vector<SubmapRecord> grown = rb;
  grown.push_back(rb.front());
  for (SubmapBlock& block : grown.back().blocks)
    for (SubmapVoxel& voxel : block.voxels) voxel.tsdf = static_cast<std::int16_t>(voxel.tsdf / 2);
  Atlas direct({}), atlas({});
  from_a.add_to(direct);
  Source(grown, T_world_b).add_to(direct);
  from_a.add_to(atlas);
  std::vector<Atlas::Submap> before;
  const Source all(grown, T_world_b);
  for (const Atlas::Submap& submap : all.submaps) {
    std::vector<Atlas::Submap> after = before;
    after.push_back(submap);
    atlas.replace({all.T_map_anchor, before}, {all.T_map_anchor, after});
    before = after;
  }
  atlas.settle();
  EXPECT_EQ(atlas.map().digest(), direct.map().digest());
  EXPECT_EQ(atlas.counters().blocks, direct.counters().blocks);
}

TEST(Atlas, KnowsWhenTheOrderBeganToMatter) {
  SubmapRecord heavy = one_voxel(100);
  heavy.blocks[0].voxels[77].weight = 255;
  const std::vector<Atlas::Submap> submaps{{0, &heavy}};
  Atlas atlas({});
  for (int i = 0; i < Voxel::kMaxWeight / 255; ++i) atlas.add({{}, submaps});
  EXPECT_TRUE(atlas.exact());
  atlas.add({{}, submaps});
  EXPECT_FALSE(atlas.exact());
  atlas.clear();
  EXPECT_TRUE(atlas.exact());
}

TEST(Atlas, SumsWhatRobotsSawOfOneVoxel) {
  const std::vector<SubmapRecord> a{one_voxel(100)}, b{one_voxel(-300)};
  Atlas atlas({});
  Source(a).add_to(atlas);
  Source(b).add_to(atlas);
  const Voxel& voxel = atlas.map().find({1, 2, 3})[77];
  EXPECT_EQ(voxel.tsdf_sum, -1000);
  EXPECT_EQ(voxel.weight, 10);
}

TEST(Atlas, LeavesOutUnlikeVoxelSizesAndCountsAFullMap) {
  const std::vector<SubmapRecord> coarse{one_voxel(0, 90000)};
  Atlas atlas({});
  Source(coarse).add_to(atlas);
  EXPECT_EQ(atlas.counters().blocks_left_out, 1u);
  EXPECT_EQ(atlas.map().used(), 0u);

  VoxelMap local = explore({}, -0.6);
  const auto records = all_submaps(local);
  AtlasConfig small;
  small.map.budget_bytes = 1 << 20;
  Atlas full(small);
  EXPECT_TRUE(full.exact());
  Source(records).add_to(full);
  EXPECT_FALSE(full.exact());
  EXPECT_EQ(full.map().used(), full.map().capacity());
  EXPECT_GT(full.map().counters().blocks_refused, 0u);
}

TEST(MakeSubmap, SurvivesItsRecord) {
  VoxelMap local = explore({}, -0.6);
  std::size_t blocks = 0;
  for (const SubmapRecord& record : all_submaps(local)) {
    const auto back = decode_submap(encode(record));
    ASSERT_TRUE(back.ok()) << back.error().text();
    ASSERT_EQ(back->blocks.size(), record.blocks.size());
    for (std::size_t b = 0; b < record.blocks.size(); ++b)
      EXPECT_TRUE(std::equal(
          record.blocks[b].voxels.begin(), record.blocks[b].voxels.end(), back->blocks[b].voxels.begin(),
          [](const SubmapVoxel& put, const SubmapVoxel& got) { return test::within_half_a_step(got, put); }));
    blocks += record.blocks.size();
  }
  EXPECT_EQ(blocks, filled_blocks(local));
}

TEST(MakeSubmap, WritesBlackAsAColour) {
  VoxelMap map{VoxelMapConfig{}};
  Voxel* block = map.find_or_add({0, 0, 0});
  block[0].add_tsdf(5, 1);
  block[0].add_color(0, 0, 0);
  block[1].add_tsdf(5, 1);
  const BlockKey keys[] = {{0, 0, 0}, {9, 9, 9}, {0, 0, 0}};
  const SubmapRecord record = make_submap(map, keys);
  ASSERT_EQ(record.blocks.size(), 1u);
  EXPECT_EQ(record.blocks[0].voxels[0].rgb, (Rgb{1, 1, 1}));
  EXPECT_EQ(record.blocks[0].voxels[1].rgb, Rgb{});
}

}  // namespace
}  // namespace onemap::mapping
