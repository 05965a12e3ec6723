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

}  // namespace onemap::mapping::match
