#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "mapping/local/match.hpp"

namespace onemap::mapping::match {

bool simd_available();

// Elements of working space that search_simd needs for a second set of at most `count` features.
std::size_t packed_elements(std::size_t count);
std::size_t block_elements(std::size_t count);

// The two nearest of b for each of a (forward) and of a for each of b (backward), SURF descriptors, eight pairs at a
// time. Both spans have the size of their set. Equal to the plain search.
void search_simd(const FeatureSet& a, const FeatureSet& b, bool same_laplacian, std::span<std::int16_t> packed,
                 std::span<std::int32_t> block, std::span<TwoNearest> forward, std::span<TwoNearest> backward);

// A distance that may be among the two smallest; of equal ones the first offered stays.
[[gnu::always_inline]] inline void offer(TwoNearest& n, std::int32_t distance, std::size_t index) {
  if (distance < n.best) {
    n.second = n.best;
    n.best = distance;
    n.index = static_cast<std::int32_t>(index);
  } else if (distance < n.second) {
    n.second = distance;
  }
}

// The same for binary features, by Hamming distance; only features of equal laplacian are compared. The twin counts
// bits by an instruction that the baseline CPU has not: 400 x 400 features take it a third of a millisecond instead of
// one.
void search_bits_plain(std::span<const BinaryFeature> a, std::span<const BinaryFeature> b,
                       std::span<TwoNearest> forward, std::span<TwoNearest> backward);
void search_bits_simd(std::span<const BinaryFeature> a, std::span<const BinaryFeature> b, std::span<TwoNearest> forward,
                      std::span<TwoNearest> backward);

}  // namespace onemap::mapping::match
