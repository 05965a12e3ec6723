#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mapping/local/descriptor_bits.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

struct MatchConfig {
  bool cross_check = true;     // the paper's filter: keep only matches found in both directions
  float max_ratio = 0.9f;      // best / second best distance (not squared), 1 = off (Lowe's test, per direction a -> b)
  bool same_laplacian = true;  // SURF: bright blobs match bright blobs only
  bool simd = true;            // false: the plain reference, which gives the same matches
};

// What an exhaustive search finds for one feature: the smallest and second smallest distance, and whose the smallest is
// (the lowest index of several). kNoDistance and -1 where there is none.
struct TwoNearest {
  static constexpr std::int32_t kNoDistance = std::numeric_limits<std::int32_t>::max();
  std::int32_t best = kNoDistance, second = kNoDistance, index = -1;
};

// A binary feature as the search takes it.
struct BinaryFeature {
  DescriptorBits bits{};
  std::int32_t laplacian = 0;
};

// k-nearest-neighbour matching (k = 2) by exhaustive search in both directions with cross check (the paper, section 3).
// Memory is taken in the constructor. Result sorted by (a); ties go to the lower index, so it is deterministic.
class Matcher {
 public:
  Matcher(const MatchConfig& config, std::size_t max_features);
  // Both sets have the same kind. The span is valid until the next call.
  std::span<const Match> match(const FeatureSet& a, const FeatureSet& b);

 private:
  bool accepted(const TwoNearest& n) const;
  void search_bits(const FeatureSet& a, const FeatureSet& b, std::span<TwoNearest> forward,
                   std::span<TwoNearest> backward);

  MatchConfig config_;
  [[maybe_unused]] std::size_t capacity_;  // only asserted
  bool simd_;
  DescriptorKind kind_ = DescriptorKind::surf;
  std::vector<TwoNearest> forward_, backward_;
  std::vector<std::int16_t> packed_;            // surf: the second set in blocks of eight, for the SIMD search
  std::vector<std::int32_t> block_;             // and what is found for it
  std::vector<BinaryFeature> bits_a_, bits_b_;  // of the binary kinds
  std::vector<Match> matches_;
};

// Distance of two descriptors: squared Euclidean over int8 (surf) or Hamming (the others). The plain reference.
std::int32_t descriptor_distance(const Descriptor& a, const Descriptor& b, DescriptorKind kind);

}  // namespace onemap::mapping
