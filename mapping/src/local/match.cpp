#include "mapping/local/match.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "match_internal.hpp"

namespace onemap::mapping {

namespace {

std::int32_t squared_euclidean(const Descriptor& a, const Descriptor& b) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    const int d = a.v[i] - b.v[i];
    sum += d * d;
  }
  return sum;
}

std::int32_t hamming(const Descriptor& a, const Descriptor& b) {
  std::int32_t bits = 0;
  for (std::size_t i = 0; i < 32; i += 8) {
    std::uint64_t x = 0, y = 0;
    std::memcpy(&x, a.v.data() + i, 8);
    std::memcpy(&y, b.v.data() + i, 8);
    bits += std::popcount(x ^ y);
  }
  return bits;
}

void offer(TwoNearest& n, std::int32_t distance, std::size_t index) {
  if (distance < n.best) {
    n.second = n.best;
    n.best = distance;
    n.index = static_cast<std::int32_t>(index);
  } else if (distance < n.second) {
    n.second = distance;
  }
}

void search_plain(const FeatureSet& a, const FeatureSet& b, bool same_laplacian, std::span<TwoNearest> forward,
                  std::span<TwoNearest> backward) {
  std::fill(forward.begin(), forward.end(), TwoNearest{});
  std::fill(backward.begin(), backward.end(), TwoNearest{});
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (same_laplacian && a.keypoints[i].laplacian != b.keypoints[j].laplacian) continue;
      const std::int32_t distance = descriptor_distance(a.descriptors[i], b.descriptors[j], a.kind);
      offer(forward[i], distance, j);
      offer(backward[j], distance, i);
    }
}

}  // namespace

std::int32_t descriptor_distance(const Descriptor& a, const Descriptor& b, DescriptorKind kind) {
  return kind == DescriptorKind::orb ? hamming(a, b) : squared_euclidean(a, b);
}

Matcher::Matcher(const MatchConfig& config, std::size_t max_features)
    : config_(config),
      capacity_(max_features),
      simd_(config.simd && match::simd_available()),
      forward_(max_features),
      backward_(max_features),
      packed_(simd_ ? match::packed_elements(max_features) : 0),
      block_(simd_ ? match::block_elements(max_features) : 0) {
  matches_.reserve(max_features);
}

bool Matcher::accepted(const TwoNearest& n) const {
  if (n.index < 0) return false;
  if (n.second == TwoNearest::kNoDistance || config_.max_ratio >= 1) return true;
  const double ratio = static_cast<double>(config_.max_ratio);
  const double factor = kind_ == DescriptorKind::orb ? ratio : ratio * ratio;  // SURF's distances are squares
  return n.best <= factor * n.second;
}

std::span<const Match> Matcher::match(const FeatureSet& a, const FeatureSet& b) {
  assert(a.kind == b.kind);
  assert(a.size() <= capacity_ && b.size() <= capacity_);
  kind_ = a.kind;
  const std::span<TwoNearest> forward(forward_.data(), a.size()), backward(backward_.data(), b.size());
  if (simd_ && a.kind == DescriptorKind::surf)
    match::search_simd(a, b, config_.same_laplacian, packed_, block_, forward, backward);
  else
    search_plain(a, b, config_.same_laplacian, forward, backward);
  matches_.clear();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const TwoNearest& n = forward[i];
    if (!accepted(n)) continue;
    const auto j = static_cast<std::size_t>(n.index);
    if (config_.cross_check && backward[j].index != static_cast<std::int32_t>(i)) continue;
    matches_.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j), n.best});
  }
  return matches_;
}

}  // namespace onemap::mapping
