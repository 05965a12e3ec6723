#pragma once
#include <cstdint>
#include <span>

namespace onemap::mapping {

struct DepthUnits {
  float metres = 0;      // a unit
  float farthest_m = 0;  // what is farther is not to be fused
};

// Readings (units) in metres: 0 nearer than kMinDepth_m and farther than kMaxDepth_m, negative beyond the farthest.
void read_depth(std::span<const std::uint16_t> depth, const DepthUnits& units, float* out_m);

// The same through a look-up table: of each pixel its number in `depth`, -1 = none, which gives 0. simd false: the
// plain twin, which gives the same bytes.
void look_up_depth(std::span<const std::uint16_t> depth, std::span<const std::int32_t> source, const DepthUnits& units,
                   bool simd, float* out_m);

}  // namespace onemap::mapping
