#include "mapping/local/match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "texture.hpp"

namespace onemap::mapping {
namespace {

// `count` random features; small values so that equal distances happen.
FeatureSet random_features(std::size_t count, std::uint32_t seed, int amplitude, DescriptorKind kind) {
  FeatureSet out;
  out.kind = kind;
  for (std::uint32_t i = 0; i < count; ++i) {
    Keypoint k;
    k.laplacian = kind == DescriptorKind::orb           ? std::int8_t{0}
                  : (test::hash(i, 900, seed) & 1) != 0 ? std::int8_t{1}
                                                        : std::int8_t{-1};
    out.keypoints.push_back(k);
    auto& v = out.descriptors.emplace_back().v;
    for (std::uint32_t c = 0; c < (is_binary(kind) ? 32U : 64U); ++c)
      v[c] = static_cast<std::int8_t>(
          static_cast<int>(test::hash(i, c, seed) % static_cast<std::uint32_t>(2 * amplitude + 1)) - amplitude);
  }
  return out;
}

// All matches from the definition: sort all distances for each feature.
std::vector<Match> slow_matches(const FeatureSet& a, const FeatureSet& b, const MatchConfig& config) {
  const auto ranked = [&](const FeatureSet& from, const FeatureSet& to, std::size_t i) {
    std::vector<std::pair<long, std::size_t>> out;
    for (std::size_t j = 0; j < to.size(); ++j) {
      if (config.same_laplacian && from.keypoints[i].laplacian != to.keypoints[j].laplacian) continue;
      long d = 0;
      for (std::size_t c = 0; c < 64; ++c) {
        const int x = from.descriptors[i].v[c], y = to.descriptors[j].v[c];
        if (is_binary(a.kind))
          for (int bit = 0; bit < 8; ++bit) d += ((x ^ y) >> bit) & 1;
        else
          d += (x - y) * (x - y);
      }
      out.emplace_back(d, j);
    }
    std::sort(out.begin(), out.end());
    return out;
  };
  std::vector<Match> out;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto near = ranked(a, b, i);
    if (near.empty()) continue;
    const double power = is_binary(a.kind) ? 1 : 2;
    if (config.max_ratio < 1 && near.size() > 1 &&
        static_cast<double>(near[0].first) >
            std::pow(static_cast<double>(config.max_ratio), power) * static_cast<double>(near[1].first))
      continue;
    if (config.cross_check && ranked(b, a, near[0].second)[0].second != i) continue;
    out.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(near[0].second),
                   static_cast<std::int32_t>(near[0].first)});
  }
  return out;
}

void expect_equal_to_slow(const FeatureSet& a, const FeatureSet& b, MatchConfig config) {
  const auto expected = slow_matches(a, b, config);
  for (const bool simd : {false, true}) {
    config.simd = simd;
    Matcher matcher(config, 200);
    const auto found = matcher.match(a, b);
    EXPECT_EQ(std::vector<Match>(found.begin(), found.end()), expected) << "simd " << simd;
  }
}

TEST(Match, EqualsTheSlowDefinition) {
  for (const auto kind : {DescriptorKind::surf, DescriptorKind::orb, DescriptorKind::surf_bits})
    for (const int amplitude : {1, 30, 127})
      for (const auto& [na, nb] : {std::pair{100, 90}, {1, 1}, {7, 17}, {64, 8}, {3, 0}, {0, 3}, {200, 1}}) {
        const FeatureSet a = random_features(static_cast<std::size_t>(na), 1, amplitude, kind);
        const FeatureSet b = random_features(static_cast<std::size_t>(nb), 2, amplitude, kind);
        expect_equal_to_slow(a, b, {});
        expect_equal_to_slow(a, b, {.cross_check = false, .max_ratio = 1.F, .same_laplacian = false});
        expect_equal_to_slow(a, b, {.cross_check = true, .max_ratio = 0.97F, .same_laplacian = false});
      }
}

TEST(Match, ExtremeDescriptorsDoNotOverflow) {
  FeatureSet a = random_features(2, 1, 1, DescriptorKind::surf), b = random_features(9, 1, 1, DescriptorKind::surf);
  a.descriptors[0].v.fill(-127);
  for (auto& d : b.descriptors) d.v.fill(127);
  expect_equal_to_slow(a, b, {.cross_check = false, .max_ratio = 1.F, .same_laplacian = false});
  EXPECT_EQ(descriptor_distance(a.descriptors[0], b.descriptors[0], DescriptorKind::surf), 64 * 254 * 254);
}

TEST(Match, ASetMatchesItself) {
  const FeatureSet a = random_features(150, 5, 127, DescriptorKind::surf);
  Matcher matcher({}, 150);
  const auto found = matcher.match(a, a);
  ASSERT_EQ(found.size(), a.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].a, i);
    EXPECT_EQ(found[i].b, i);
    EXPECT_EQ(found[i].distance, 0);
  }
}

TEST(Match, TiesGoToTheLowerIndex) {
  FeatureSet a = random_features(1, 5, 50, DescriptorKind::surf), b;
  for (int i = 0; i < 20; ++i) {
    b.keypoints.push_back(a.keypoints[0]);
    b.descriptors.push_back(a.descriptors[0]);
  }
  for (const bool simd : {false, true}) {
    Matcher matcher({.cross_check = true, .max_ratio = 1.F, .simd = simd}, 20);
    const auto found = matcher.match(a, b);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].b, 0);
  }
}

TEST(Match, HammingCountsBits) {
  Descriptor a, b;
  b.v[0] = 0b0101;
  b.v[31] = -1;
  b.v[40] = 7;  // beyond the 32 bytes of ORB
  EXPECT_EQ(descriptor_distance(a, b, DescriptorKind::orb), 10);
}

}  // namespace
}  // namespace onemap::mapping
