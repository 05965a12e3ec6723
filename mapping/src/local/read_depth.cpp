#include "local/read_depth.hpp"

#include <cstddef>

#include "hal/base/twin.hpp"
#include "mapping/local/depth_range.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::mapping {
namespace {

inline float in_metres(std::uint16_t reading, const DepthUnits& units) {
  const float z = units.metres * static_cast<float>(reading);
  const float far = z <= kMaxDepth_m ? -z : 0.f, near = z >= kMinDepth_m ? z : 0.f;
  return z > units.farthest_m ? far : near;
}

#if defined(__x86_64__)
// Whole eights of pixels; how many that were. Two readings are loaded at once, of which the last one is the second.
[[gnu::target("avx2")]] std::size_t look_up_eights(std::span<const std::uint16_t> depth,
                                                   std::span<const std::int32_t> source, const DepthUnits& units,
                                                   float* out_m) {
  if (depth.size() < 2) return 0;
  const __m256i last_pair = _mm256_set1_epi32(static_cast<int>(depth.size()) - 2);
  const __m256 metres = _mm256_set1_ps(units.metres), farthest = _mm256_set1_ps(units.farthest_m);
  const __m256 least = _mm256_set1_ps(kMinDepth_m), most = _mm256_set1_ps(kMaxDepth_m), none = _mm256_setzero_ps();
  std::size_t i = 0;
  for (; i + 8 <= source.size(); i += 8) {
    const __m256i pixel = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(&source[i]));
    const __m256i first = _mm256_min_epi32(pixel, last_pair), there = _mm256_cmpgt_epi32(pixel, _mm256_set1_epi32(-1));
    const __m256i pair = _mm256_mask_i32gather_epi32(_mm256_setzero_si256(), reinterpret_cast<const int*>(depth.data()),
                                                     first, there, sizeof(std::uint16_t));
    const __m256i shift = _mm256_slli_epi32(_mm256_sub_epi32(pixel, first), 4);
    const __m256i reading = _mm256_and_si256(_mm256_srlv_epi32(pair, shift), _mm256_set1_epi32(0xFFFF));
    const __m256 z = _mm256_mul_ps(metres, _mm256_cvtepi32_ps(reading));
    const __m256 far = _mm256_and_ps(_mm256_sub_ps(none, z), _mm256_cmp_ps(z, most, _CMP_LE_OQ));
    const __m256 near = _mm256_and_ps(z, _mm256_cmp_ps(z, least, _CMP_GE_OQ));
    _mm256_storeu_ps(out_m + i, _mm256_blendv_ps(near, far, _mm256_cmp_ps(z, farthest, _CMP_GT_OQ)));
  }
  return i;
}
#else
std::size_t look_up_eights(std::span<const std::uint16_t>, std::span<const std::int32_t>, const DepthUnits&, float*) {
  return 0;
}
#endif

}  // namespace

void read_depth(std::span<const std::uint16_t> depth, const DepthUnits& units, float* out_m) {
  for (std::size_t i = 0; i < depth.size(); ++i) out_m[i] = in_metres(depth[i], units);
}

void look_up_depth(std::span<const std::uint16_t> depth, std::span<const std::int32_t> source, const DepthUnits& units,
                   bool simd, float* out_m) {
  std::size_t i = simd && simd_available() ? look_up_eights(depth, source, units, out_m) : 0;
  for (; i < source.size(); ++i)
    out_m[i] = source[i] < 0 ? 0.f : in_metres(depth[static_cast<std::size_t>(source[i])], units);
}

}  // namespace onemap::mapping
