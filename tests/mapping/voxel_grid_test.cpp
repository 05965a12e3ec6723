#include "mapping/local/voxel_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

std::vector<Vector3f> random_points(std::size_t n, double extent_m, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vector3f> points(n);
  for (auto& p : points) {
    for (int i = 0; i < 3; ++i) p[i] = static_cast<float>(random.uniform(-extent_m, extent_m));
  }
  return points;
}

// The slow plain reference: an ordered map of voxels.
std::vector<Vector3f> reference(const std::vector<Vector3f>& in, float leaf_m) {
  std::map<std::array<long, 3>, std::pair<Vector3d, int>> voxels;
  for (const auto& p : in) {
    std::array<long, 3> key{};
    for (int i = 0; i < 3; ++i) key[static_cast<std::size_t>(i)] = std::lround(std::floor(p[i] * (1 / leaf_m)));
    auto& [sum, count] = voxels.try_emplace(key, Vector3d::Zero(), 0).first->second;
    sum += p.cast<double>();
    ++count;
  }
  std::vector<Vector3f> out;
  for (const auto& [key, voxel] : voxels) out.emplace_back((voxel.first / voxel.second).cast<float>());
  return out;
}

TEST(VoxelGrid, EqualsThePlainReference) {
  for (const auto& [leaf_m, extent_m] : {std::pair{0.05f, 0.6}, {0.02f, 2.0}, {0.3f, 0.5}, {0.001f, 900.0}}) {
    const auto in = random_points(20000, extent_m, 17);
    VoxelGrid grid(leaf_m, in.size());
    std::vector<Vector3f> out(in.size());
    out.resize(grid.downsample(in, out));
    const auto expected = reference(in, leaf_m);
    ASSERT_EQ(out.size(), expected.size());
    for (std::size_t i = 0; i < out.size(); ++i) ASSERT_LT((out[i] - expected[i]).norm(), 1e-6f * (1 + extent_m)) << i;
  }
}

TEST(VoxelGrid, RepeatsBitByBitAndIgnoresWhatWasBefore) {
  const auto in = random_points(5000, 1, 23), other = random_points(5000, 1, 24);
  VoxelGrid grid(0.1f, 5000);
  std::vector<Vector3f> a(5000), b(5000);
  const std::size_t n = grid.downsample(in, a);
  grid.downsample(other, b);
  ASSERT_EQ(grid.downsample(in, b), n);
  for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(a[i], b[i]);
}

TEST(VoxelGrid, OrderOfTheInputDoesNotMatter) {
  auto in = random_points(5000, 1, 29);
  VoxelGrid grid(0.1f, in.size());
  std::vector<Vector3f> a(in.size()), b(in.size());
  const std::size_t n = grid.downsample(in, a);
  std::reverse(in.begin(), in.end());
  ASSERT_EQ(grid.downsample(in, b), n);
  for (std::size_t i = 0; i < n; ++i) ASSERT_LT((a[i] - b[i]).norm(), 1e-6f);
}

TEST(VoxelGrid, BordersAndRefusals) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  const std::vector<Vector3f> in{{-0.01f, 0, 0}, {0.01f, 0, 0}, {kNan, 0, 0}, {0, kInf, 0}, {0, 0, 2e6f}};
  VoxelGrid grid(1, in.size());
  std::vector<Vector3f> out(in.size());
  ASSERT_EQ(grid.downsample(in, out), 2u);  // zero is a border; the rest is left out
  EXPECT_EQ(out[0], in[0]);
  EXPECT_EQ(out[1], in[1]);
  EXPECT_EQ(grid.downsample(in, std::span(out).first(1)), 1u);
  EXPECT_EQ(grid.downsample({}, out), 0u);
}

}  // namespace
}  // namespace onemap::mapping
