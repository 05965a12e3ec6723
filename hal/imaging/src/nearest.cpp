#include "nearest.hpp"

#include <algorithm>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::hal::imaging::nearest {

namespace {

using footprints::Covered;

void keep(std::uint16_t& pixel, std::uint16_t less_1) { pixel = std::min(pixel, less_1); }

// Most readings cover 1 or 2 pixels each way: there, without a loop, a pixel may be looked at twice.
void keep_wide(std::uint16_t* pixel, std::size_t columns, std::size_t wide, std::size_t high, std::uint16_t less_1) {
  if (wide <= 2 && high <= 2) {
    std::uint16_t* below = pixel + (high - 1) * columns;
    keep(pixel[0], less_1);
    keep(pixel[wide - 1], less_1);
    keep(below[0], less_1);
    keep(below[wide - 1], less_1);
    return;
  }
  for (std::size_t v = 0; v < high; ++v, pixel += columns)
    for (std::size_t u = 0; u < wide; ++u) keep(pixel[u], less_1);
}

void keep_some(const Covered& row, std::size_t begin, std::size_t end, std::size_t columns,
               std::uint16_t* __restrict image) {
  const std::int32_t* first = row.first.data();
  const std::uint16_t *size = row.size.data(), *less_1 = row.less_1.data();
  for (std::size_t i = begin; i < end; ++i) {
    if (first[i] == footprints::kNowhere) continue;
    std::uint16_t* pixel = image + first[i];
    if (size[i] == 0x0101)
      keep(*pixel, less_1[i]);
    else
      keep_wide(pixel, columns, size[i] & 0xFFu, size[i] >> 8u, less_1[i]);
  }
}

}  // namespace

void keep_plain(const Covered& row, std::size_t columns, std::uint16_t* image) {
  keep_some(row, 0, row.first.size(), columns, image);
}

#if defined(__x86_64__)
namespace {

constexpr std::size_t kAtOnce = 8;

// Whether the eight readings from i lie beside each other in the image and all cover the same, 1 or 2 pixels each way.
[[gnu::target("avx2")]] inline bool beside_each_other(const Covered& row, std::size_t i) {
  const std::uint16_t size = row.size[i];
  if (row.first[i] < 0 || (size & 0xFF) > 2 || size > 0x02FF) return false;
  const __m256i first = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(&row.first[i]));
  const __m256i expected = _mm256_add_epi32(_mm256_set1_epi32(row.first[i]), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  const __m128i sizes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&row.size[i]));
  const __m128i same_size = _mm_cmpeq_epi16(sizes, _mm_set1_epi16(static_cast<std::int16_t>(size)));
  return _mm256_movemask_epi8(_mm256_cmpeq_epi32(first, expected)) == -1 && _mm_movemask_epi8(same_size) == 0xFFFF;
}

[[gnu::target("avx2")]] inline void keep_eight(const Covered& row, std::size_t i, std::size_t columns,
                                               std::uint16_t* image) {
  const bool two_wide = (row.size[i] & 0xFF) == 2;
  const std::size_t high = row.size[i] >> 8u;
  __m128i depths = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&row.less_1[i]));
  if (two_wide) depths = _mm_min_epu16(depths, _mm_alignr_epi8(depths, _mm_set1_epi16(-1), 14));
  std::uint16_t* pixel = image + row.first[i];
  for (std::size_t v = 0; v < high; ++v, pixel += columns) {
    auto* eight = reinterpret_cast<__m128i*>(pixel);
    _mm_storeu_si128(eight, _mm_min_epu16(_mm_loadu_si128(eight), depths));
    if (two_wide) keep(pixel[kAtOnce], row.less_1[i + kAtOnce - 1]);
  }
}

}  // namespace

[[gnu::target("avx2")]] void keep_simd(const Covered& row, std::size_t columns, std::uint16_t* image) {
  std::size_t i = 0;
  for (; i + kAtOnce <= row.first.size(); i += kAtOnce) {
    if (beside_each_other(row, i))
      keep_eight(row, i, columns, image);
    else
      keep_some(row, i, i + kAtOnce, columns, image);
  }
  keep_some(row, i, row.first.size(), columns, image);
}

#else

void keep_simd(const Covered& row, std::size_t columns, std::uint16_t* image) { keep_plain(row, columns, image); }

#endif

}  // namespace onemap::hal::imaging::nearest
