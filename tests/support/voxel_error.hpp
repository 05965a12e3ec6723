#pragma once
#include <algorithm>
#include <cstdlib>

#include "mapping/records/submap.hpp"

namespace onemap::test {

// Whether a voxel that was decoded is what was encoded, within what submap.hpp promises: half a step.
inline bool within_half_a_step(const mapping::SubmapVoxel& got, const mapping::SubmapVoxel& put) {
  if (put.weight == 0) return got.weight == 0 && got.tsdf == 0 && got.rgb == mapping::Rgb{};
  const bool black = std::max({put.rgb[0], put.rgb[1], put.rgb[2]}) < 7;  // its green may have to be 6, for 0 is none
  const auto off = [&](std::size_t i) { return std::abs(got.rgb[i] - put.rgb[i]); };
  return std::abs(got.tsdf - put.tsdf) <= 20 && 2 * std::abs(got.weight - put.weight) <= std::max<int>(put.weight, 2) &&
         off(1) <= (black ? 6 : 3) && off(0) <= 9 && off(2) <= 9 &&
         (got.rgb == mapping::Rgb{}) == (put.rgb == mapping::Rgb{});
}

}  // namespace onemap::test
