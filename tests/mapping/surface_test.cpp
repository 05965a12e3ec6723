#include "mapping/local/surface.hpp"

#include <gtest/gtest.h>

#include <map>

#include "mapping/local/make_submap.hpp"
#include "support/analytic_scene.hpp"

namespace onemap::mapping {
namespace {

using test::look_at;
using test::Scene;

// A map filled from a signed distance (metres, negative inside), without a camera.
template <class Distance>
void fill(VoxelMap& map, int reach_blocks, Distance&& distance) {
  for (std::int32_t z = -reach_blocks; z < reach_blocks; ++z)
    for (std::int32_t y = -reach_blocks; y < reach_blocks; ++y)
      for (std::int32_t x = -reach_blocks; x < reach_blocks; ++x) {
        Voxel* block = map.find_or_add({x, y, z});
        ASSERT_NE(block, nullptr);
        for (int i = 0; i < kBlockVoxels; ++i) {
          const Vector3d p = Vector3d(8 * x + i % 8 + 0.5, 8 * y + i / 8 % 8 + 0.5, 8 * z + i / 64 + 0.5) * 0.02;
          const double units = distance(p) / 0.06 * kTsdfOne;
          if (units >= -kTsdfOne && units <= kTsdfOne) block[i].add_tsdf(static_cast<int>(std::lround(units)), 4);
        }
      }
}

// The directed edges of the triangles, and how often each occurs.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_edges(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> out;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) ++out[{t[i], t[(i + 1) % 3]}];
  return out;
}

// A surface without border has every edge as often in one direction as in the other.
bool is_closed(const TriangleMesh& mesh) {
  const auto edges = directed_edges(mesh);
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) {
    const auto back = edges.find({e.first.second, e.first.first});
    return back != edges.end() && back->second == e.second;
  });
}

bool is_manifold(const TriangleMesh& mesh) {
  const auto edges = directed_edges(mesh);
  return std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 1; });
}

double volume(const TriangleMesh& mesh) {
  double out = 0;
  for (const auto& t : mesh.triangles)
    out += mesh.vertices[t[0]].cast<double>().dot(
               mesh.vertices[t[1]].cast<double>().cross(mesh.vertices[t[2]].cast<double>())) /
           6;
  return out;
}

TEST(Surface, SphereIsClosedWeldedAndOriented) {
  VoxelMap map{VoxelMapConfig{}};
  const Vector3d centre(0.013, -0.021, 0.007);
  fill(map, 3, [&](const Vector3d& p) { return (p - centre).norm() - 0.3; });
  const TriangleMesh mesh = extract_mesh(map);
  ASSERT_GT(mesh.triangles.size(), 1000u);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_TRUE(is_manifold(mesh));
  // Euler: V - E + F = 2 with E = 3 F / 2, so V = F / 2 + 2, which doubled vertices would break.
  EXPECT_EQ(mesh.vertices.size(), mesh.triangles.size() / 2 + 2);
  EXPECT_NEAR(volume(mesh), 4.0 / 3 * 3.14159265 * 0.027, 0.001);  // positive: counter-clockwise from outside
  double worst = 0, least_cosine = 1;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d d = mesh.vertices[i].cast<double>() - centre;
    worst = std::max(worst, std::abs(d.norm() - 0.3));
    least_cosine = std::min(least_cosine, mesh.normals[i].cast<double>().dot(d.normalized()));
  }
  EXPECT_LT(worst, 0.02 * 0.05);  // a twentieth of a voxel
  EXPECT_GT(least_cosine, 0.99);
}

// Random signs make every case of the table and every ambiguous face occur: still no holes.
TEST(Surface, EveryCaseClosesWithItsNeighbours) {
  VoxelMap map{VoxelMapConfig{}};
  std::uint64_t state = 88172645463325252u;
  for (std::int32_t b = 0; b < 8; ++b) {
    Voxel* block = map.find_or_add({b & 1, (b >> 1) & 1, (b >> 2) & 1});
    for (int i = 0; i < kBlockVoxels; ++i) {
      state ^= state << 13;
      state ^= state >> 7;
      state ^= state << 17;
      const int x = 8 * (b & 1) + i % 8, y = 8 * ((b >> 1) & 1) + i / 8 % 8, z = 8 * (b >> 2) + i / 64;
      const bool border = std::min({x, y, z}) == 0 || std::max({x, y, z}) == 15;
      block[i].add_tsdf(border || state % 2 == 0 ? 300 : -300, 2);
    }
  }
  const TriangleMesh mesh = extract_mesh(map);
  EXPECT_GT(mesh.triangles.size(), 5000u);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_GT(volume(mesh), 0);
}

TEST(Surface, LeavesOutLightVoxelsAndFalseSteps) {
  VoxelMap map{VoxelMapConfig{}};
  Voxel* block = map.find_or_add({0, 0, 0});
  for (int i = 0; i < kBlockVoxels; ++i) block[i].add_tsdf(i / 64 < 4 ? -200 : 200, 2);
  EXPECT_EQ(extract_mesh(map, 2).triangles.size(), 7u * 7 * 2);
  EXPECT_TRUE(extract_mesh(map, 3).triangles.empty());
  for (int i = 0; i < kBlockVoxels; ++i) {  // from the back of one surface to the front of another
    block[i] = {};
    block[i].add_tsdf((i / 64 < 4 ? 0 : 1950) - 300 * (i / 64), 2);
  }
  const TriangleMesh mesh = extract_mesh(map, 2);
  EXPECT_FALSE(mesh.triangles.empty());
  for (const Vector3f& p : mesh.vertices) EXPECT_GT(std::abs(p[2] - 0.08f), 0.015f) << "none where they meet";
}

double area(const TriangleMesh& mesh) {
  double out = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3f& a = mesh.vertices[t[0]];
    out += 0.5 * static_cast<double>((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm());
  }
  return out;
}

// Blocks as they are saved give the surface that their map gives, to the bit: a ball, and a hole on a corner of blocks.
TEST(Surface, OfSavedBlocksIsTheirMaps) {
  VoxelMap map{VoxelMapConfig{}};
  fill(map, 3, [](const Vector3d& p) { return p.norm() - 0.3; });
  map.find_or_add({0, 0, 0})[3].add_color(10, 20, 30);
  map.find_or_add({1, 0, -1})[0] = {};
  std::vector<BlockKey> keys;
  map.for_each_sorted([&](const BlockView& block) {
    if (block.key != BlockKey{1, 1, 0}) keys.push_back(block.key);
  });
  VoxelMap same = map.sibling();
  for (const BlockKey& key : keys) std::copy_n(map.find(key), kBlockVoxels, same.find_or_add(key));
  const SubmapRecord saved = make_submap(map, keys);
  std::vector<const SubmapBlock*> blocks;
  for (const SubmapBlock& block : saved.blocks) blocks.push_back(&block);
  const TriangleMesh expected = extract_mesh(same), mesh = extract_mesh(blocks, map.config().voxel_m);
  ASSERT_GT(expected.vertices.size(), 1000u);
  EXPECT_EQ(mesh.vertices, expected.vertices);
  EXPECT_EQ(mesh.normals, expected.normals);
  EXPECT_EQ(mesh.colors, expected.colors);
  EXPECT_EQ(mesh.triangles, expected.triangles);
  EXPECT_TRUE(extract_mesh(blocks, map.config().voxel_m, 5).triangles.empty());
}

// Some at a time, in their order, they give that surface, too.
TEST(Surface, OfBlocksThatComeOneByOneIsTheSame) {
  VoxelMap map{VoxelMapConfig{}};
  fill(map, 3, [](const Vector3d& p) { return p.norm() - 0.3; });
  std::vector<BlockKey> keys;
  map.for_each_sorted([&](const BlockView& block) { keys.push_back(block.key); });
  const std::vector<SubmapBlock> all = make_submap(map, keys).blocks;
  std::vector<const SubmapBlock*> whole;
  for (const SubmapBlock& block : all) whole.push_back(&block);
  const TriangleMesh expected = extract_mesh(whole, map.config().voxel_m);
  ASSERT_GT(expected.triangles.size(), 1000u);
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, all.size()}) {
    BlockMesher mesher(map.config().voxel_m);
    for (std::size_t i = 0; i < all.size(); i += at_once) {
      const auto from = all.begin() + static_cast<std::ptrdiff_t>(i);
      ASSERT_TRUE(mesher.add({from, from + static_cast<std::ptrdiff_t>(std::min(at_once, all.size() - i))}));
    }
    EXPECT_FALSE(mesher.add({all.back()})) << "it was there";
    const TriangleMesh mesh = mesher.take();
    EXPECT_EQ(mesh.vertices, expected.vertices);
    EXPECT_EQ(mesh.normals, expected.normals);
    EXPECT_EQ(mesh.triangles, expected.triangles);
  }
}

// A plane that is seen at a slant: its distance along the optical axis, z, is `tan` times too large, so that at 70
// degrees the band is as thick as a cell's diagonal, and at 75 and 78 thinner; there the distance may change between
// neighbours by more than its whole range.
TEST(Surface, SeenAtASlantIsNotInStripes) {
  for (const auto& [tan, least] : {std::pair(2.747, 0.93), std::pair(3.732, 0.8), std::pair(4.705, 0.45)}) {
    VoxelMap map{VoxelMapConfig{}};
    fill(map, 3, [tan = tan](const Vector3d& p) { return p[2] - tan * p[0]; });
    const double side = 2 * 3 * 8 * 0.02;  // of the box; the plane leaves it through its top and bottom
    const double whole = side * side / tan * std::sqrt(1 + tan * tan);
    const TriangleMesh mesh = extract_mesh(map);
    EXPECT_GT(area(mesh), least * whole) << tan;
    EXPECT_LT(area(mesh), whole) << tan;
    for (const Vector3f& p : mesh.vertices)
      ASSERT_LT(std::abs(static_cast<double>(p[2]) - tan * static_cast<double>(p[0])), 0.004 * tan) << tan;
  }
}

// A voxel that nobody saw is guessed from its neighbours, also where it is in a margin of several blocks.
TEST(Surface, ClosesOverOneUnseenVoxel) {
  const Vector3d normal = Vector3d(1, 2, -1.5).normalized();
  const auto plane = [&](const Vector3d& p) { return p.dot(normal); };
  VoxelMap whole{VoxelMapConfig{}};
  fill(whole, 1, plane);
  const std::size_t triangles = extract_mesh(whole).triangles.size();
  for (const int hole : {0, 7, 7 + 8 * 7, 7 + 8 * 7 + 64 * 7}) {
    VoxelMap map{VoxelMapConfig{}};
    fill(map, 1, plane);
    map.find_or_add({-1, -1, -1})[hole] = {};
    const TriangleMesh mesh = extract_mesh(map);
    EXPECT_EQ(mesh.triangles.size(), triangles) << hole;
    for (const Vector3f& p : mesh.vertices) ASSERT_NEAR(plane(p.cast<double>()), 0, 1e-3) << hole;
  }
}

// Colour was seen in one voxel only: the edges next to it have it, and so have those of which no end was seen in
// colour, but a neighbour was.
TEST(Surface, AnEdgeWithoutAColouredEndHasItsNeighbours) {
  VoxelMap map{VoxelMapConfig{}};
  Voxel* block = map.find_or_add({0, 0, 0});
  for (int i = 0; i < kBlockVoxels; ++i) block[i].add_tsdf(i / 64 < 4 ? -200 : 200, 2);
  block[4 * 64 + 4 * 8 + 4].add_color(90, 120, 150);
  const TriangleMesh mesh = extract_mesh(map, 2);
  ASSERT_EQ(mesh.vertices.size(), 64u);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3f voxels = mesh.vertices[i] / 0.02f - Vector3f(4.5f, 4.5f, 0);
    const bool near = std::max(std::abs(voxels[0]), std::abs(voxels[1])) < 1.1f;
    EXPECT_EQ(mesh.colors[i], near ? (Rgb{90, 120, 150}) : Rgb{}) << voxels.transpose();
  }
}

// A room with a sphere seen by a moving camera: the surface found lies on the true one, once, with its colour and
// normal.
TEST(Surface, OfARenderedRoomLiesOnTheTruth) {
  Scene scene;
  scene.spheres.push_back({Vector3d(0.1, 0.2, -0.3), 0.4});
  for (const bool distorted : {false, true}) {
    const auto k = test::small_camera(distorted);
    const RayTable rays(k);
    VoxelMap map{VoxelMapConfig{}};
    for (int i = 0; i < 12; ++i) {
      const double s = -0.8 + 1.6 * i / 11;
      const auto frame = test::render(scene, k, rays, look_at({-1.2, s, 0.6 + 0.3 * s}, {0.4, 0.2 - 0.3 * s, -0.3}));
      map.integrate(frame.view(), rays, frame.T_world_camera);
    }
    const TriangleMesh mesh = extract_mesh(map);
    ASSERT_GT(mesh.vertices.size(), 15000u);
    double sum = 0, cosine = 0, color = 0;
    std::size_t far = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Vector3d p = mesh.vertices[i].cast<double>();
      const double error = scene.distance(p);
      sum += error;
      far += error > 0.02;
      cosine += mesh.normals[i].cast<double>().dot(scene.normal(p));
      for (int c = 0; c < 3; ++c) color += std::abs(mesh.colors[i][static_cast<std::size_t>(c)] - Scene::color(p, c));
    }
    const auto n = static_cast<double>(mesh.vertices.size());
    EXPECT_LT(sum / n, 0.1 * 0.02) << "mean error, a tenth of a voxel";
    EXPECT_LT(static_cast<double>(far), 0.002 * n) << "farther than a voxel";
    EXPECT_GT(cosine / n, 0.98);
    EXPECT_LT(color / n / 3, 8);
  }
}

}  // namespace
}  // namespace onemap::mapping
