#include "mapping/local/match.hpp"

#include <algorithm>
#include <cassert>

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

void search_plain(const FeatureSet& a, const FeatureSet& b, bool same_laplacian, std::span<TwoNearest> forward,
                  std::span<TwoNearest> backward) {
  std::fill(forward.begin(), forward.end(), TwoNearest{});
  std::fill(backward.begin(), backward.end(), TwoNearest{});
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (same_laplacian && a.keypoints[i].laplacian != b.keypoints[j].laplacian) continue;
      const std::int32_t distance = descriptor_distance(a.descriptors[i], b.descriptors[j], a.kind);
      match::offer(forward[i], distance, j);
      match::offer(backward[j], distance, i);
    }
}

void pack(const FeatureSet& set, bool same_laplacian, std::vector<BinaryFeature>& out) {
  out.clear();
  for (std::size_t i = 0; i < set.size(); ++i)
    out.push_back({to_bits(set.descriptors[i], set.kind), same_laplacian ? set.keypoints[i].laplacian : 0});
}

}  // namespace

std::int32_t descriptor_distance(const Descriptor& a, const Descriptor& b, DescriptorKind kind) {
  if (!is_binary(kind)) return squared_euclidean(a, b);
  return hamming_distance(to_bits(a, kind), to_bits(b, kind));
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
  bits_a_.reserve(max_features);
  bits_b_.reserve(max_features);
}

bool Matcher::accepted(const TwoNearest& n) const {
  if (n.index < 0) return false;
  if (n.second == TwoNearest::kNoDistance || config_.max_ratio >= 1) return true;
  const double ratio = static_cast<double>(config_.max_ratio);
  const double factor = is_binary(kind_) ? ratio : ratio * ratio;  // SURF's distances are squares
  return n.best <= factor * n.second;
}

void Matcher::search_bits(const FeatureSet& a, const FeatureSet& b, std::span<TwoNearest> forward,
                          std::span<TwoNearest> backward) {
  pack(a, config_.same_laplacian, bits_a_);
  pack(b, config_.same_laplacian, bits_b_);
  (simd_ ? match::search_bits_simd : match::search_bits_plain)(bits_a_, bits_b_, forward, backward);
}

std::span<const Match> Matcher::match(const FeatureSet& a, const FeatureSet& b) {
  assert(a.kind == b.kind);
  assert(a.size() <= capacity_ && b.size() <= capacity_);
  kind_ = a.kind;
  const std::span<TwoNearest> forward(forward_.data(), a.size()), backward(backward_.data(), b.size());
  if (is_binary(a.kind))
    search_bits(a, b, forward, backward);
  else if (simd_)
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
