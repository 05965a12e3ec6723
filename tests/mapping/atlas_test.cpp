#include "mapping/team/atlas.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/local/surface.hpp"
#include "support/analytic_scene.hpp"
#include "support/random.hpp"
#include "support/whole_atlas.hpp"

namespace onemap::mapping {
namespace {

using test::look_at;
using test::Scene;

const RobotId kA = RobotId::from_name("robot1"), kB = RobotId::from_name("robot2"), kC = RobotId::from_name("robot3");

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

void append(std::vector<Atlas::Submap>& to, const RobotId& robot, const std::vector<SubmapRecord>& records) {
  for (std::size_t i = 0; i < records.size(); ++i) to.push_back({robot, static_cast<std::uint32_t>(i), &records[i]});
}

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
  std::vector<Atlas::Submap> submaps;
  append(submaps, kA, records);
  Atlas atlas({});
  test::rebuild(atlas, {kA, {{kA, {}}}, 0}, submaps);
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
  std::vector<Atlas::Submap> submaps;
  append(submaps, kB, rb);
  append(submaps, kA, ra);
  const SolutionRecord solution{kA, {{kA, {}}, {kB, quantize(T_world_b)}}, 1};
  Atlas atlas({});
  test::rebuild(atlas, solution, submaps);
  const std::uint64_t digest = atlas.digest(), map_digest = atlas.map().digest();
  test::Random random(9);
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = submaps.size(); k > 1; --k) std::swap(submaps[k - 1], submaps[random.next() % k]);
    Atlas again({});
    test::rebuild(again, solution, submaps);
    EXPECT_EQ(again.digest(), digest);
    test::rebuild(atlas, solution, submaps);  // and a used atlas forgets what it held
    EXPECT_EQ(atlas.digest(), digest);
  }
  SolutionRecord other = solution;
  other.links_used = 2;  // the digest covers the solution too
  test::rebuild(atlas, other, submaps);
  EXPECT_EQ(atlas.map().digest(), map_digest);
  EXPECT_NE(atlas.digest(), digest);
}

// Two robots with frames far from each other in angle and place, one with coarser voxels: one surface, at the truth.
TEST(Atlas, MovedAndResampledRobotsLieOnTheTruth) {
  const Pose T_world_b = motion(0.7, -0.4, 1.1, 0.5, -0.3, 0.2), T_world_c = motion(-0.3, 0.8, -0.2, -2, 1, 0.1);
  VoxelMap a = explore({}, -0.6), b = explore(T_world_b, -0.3), c = explore(T_world_c, 0.0, 0.025f, 0.075f);
  const auto ra = all_submaps(a), rb = all_submaps(b), rc = all_submaps(c);
  std::vector<Atlas::Submap> submaps;
  append(submaps, kA, ra);
  append(submaps, kB, rb);
  append(submaps, kC, rc);
  Atlas atlas({});
  test::rebuild(atlas, {kA, {{kA, {}}, {kB, quantize(T_world_b)}, {kC, quantize(T_world_c)}}, 2}, submaps);
  EXPECT_EQ(atlas.counters().robots, 3u);
  const Error alone = surface_error(a, {}), all = surface_error(atlas.map(), {});
  EXPECT_LT(all.mean_m, 0.15 * 0.02) << "mean error in voxels: " << all.mean_m / 0.02;
  EXPECT_LT(all.far_share, 0.005);
  EXPECT_GT(all.vertices, alone.vertices);
  // A doubled surface would double the vertices of what all three see.
  EXPECT_LT(all.vertices, 1.5 * static_cast<double>(alone.vertices));

  // Each robot alone keeps most of its surface when it is moved.
  for (const auto* robot : {&kB, &kC}) {
    Atlas one({});
    test::rebuild(one, {*robot, {{*robot, quantize(*robot == kB ? T_world_b : T_world_c)}}, 0}, submaps);
    const Error moved = surface_error(one.map(), {});
    EXPECT_LT(moved.mean_m, 0.15 * 0.02);
    EXPECT_GT(static_cast<double>(moved.vertices), 0.85 * static_cast<double>(alone.vertices));
  }
}

TEST(Atlas, LeavesOutRobotsWithoutASolution) {
  VoxelMap a = explore({}, -0.6), b = explore({}, 0.1);
  const auto ra = all_submaps(a), rb = all_submaps(b);
  std::vector<Atlas::Submap> only_a, both;
  append(only_a, kA, ra);
  append(both, kA, ra);
  append(both, kB, rb);
  Atlas one({}), two({});
  test::rebuild(one, {kA, {{kA, {}}}, 0}, only_a);
  test::rebuild(two, {kA, {{kA, {}}}, 0}, both);
  EXPECT_EQ(one.digest(), two.digest());
  EXPECT_EQ(two.counters().robots, 1u);
}

SubmapRecord one_voxel(std::int16_t tsdf, std::int32_t voxel_um = 20000) {
  SubmapRecord out{0, voxel_um, 3 * voxel_um, {{{1, 2, 3}, {}}}};
  out.blocks[0].voxels[77] = {tsdf, 5, {10, 20, 30}};
  return out;
}

TEST(Atlas, LaterVersionReplacesTheEarlier) {
  const SubmapRecord old = one_voxel(100), now = one_voxel(-300);
  const std::vector<Atlas::Submap> submaps{{kA, 4, &now}, {kA, 3, &old}};
  Atlas atlas({});
  test::rebuild(atlas, {kA, {{kA, {}}}, 0}, submaps);
  const Voxel* block = atlas.map().find({1, 2, 3});
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block[77].tsdf(), -300);
  EXPECT_EQ(block[77].weight, 5);
  EXPECT_EQ(block[77].color(), (Rgb{10, 20, 30}));
  EXPECT_EQ(atlas.counters().blocks, 1u);
}

TEST(Atlas, SumsWhatRobotsSawOfOneVoxel) {
  const SubmapRecord a = one_voxel(100), b = one_voxel(-300);
  const std::vector<Atlas::Submap> submaps{{kA, 0, &a}, {kB, 0, &b}};
  Atlas atlas({});
  test::rebuild(atlas, {kA, {{kA, {}}, {kB, {}}}, 1}, submaps);
  const Voxel& voxel = atlas.map().find({1, 2, 3})[77];
  EXPECT_EQ(voxel.tsdf_sum, -1000);
  EXPECT_EQ(voxel.weight, 10);
}

TEST(Atlas, LeavesOutUnlikeVoxelSizesAndCountsAFullMap) {
  const SubmapRecord coarse = one_voxel(0, 90000);
  const std::vector<Atlas::Submap> submaps{{kA, 0, &coarse}};
  Atlas atlas({});
  test::rebuild(atlas, {kA, {{kA, {}}}, 0}, submaps);
  EXPECT_EQ(atlas.counters().blocks_left_out, 1u);
  EXPECT_EQ(atlas.map().used(), 0u);

  VoxelMap local = explore({}, -0.6);
  const auto records = all_submaps(local);
  std::vector<Atlas::Submap> many;
  append(many, kA, records);
  AtlasConfig small;
  small.map.budget_bytes = 1 << 20;
  Atlas full(small);
  test::rebuild(full, {kA, {{kA, {}}}, 0}, many);
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
      EXPECT_TRUE(std::equal(record.blocks[b].voxels.begin(), record.blocks[b].voxels.end(),
                             back->blocks[b].voxels.begin(), [](const SubmapVoxel& x, const SubmapVoxel& y) {
                               return x.tsdf == y.tsdf && x.weight == y.weight && x.rgb == y.rgb;
                             }));
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
