#include "nearest.hpp"

#include <algorithm>
#include <cstring>

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

// Whether four readings from i lie beside each other in the image and all cover the same, 1 or 2 pixels each way.
[[gnu::target("avx2")]] inline bool four_beside_each_other(const Covered& row, std::size_t i) {
  const std::uint16_t size = row.size[i];
  if (row.first[i] < 0 || (size & 0xFF) > 2 || size > 0x02FF) return false;
  const __m128i first = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&row.first[i]));
  const __m128i expected = _mm_add_epi32(_mm_set1_epi32(row.first[i]), _mm_setr_epi32(0, 1, 2, 3));
  std::uint64_t sizes = 0;
  std::memcpy(&sizes, &row.size[i], sizeof sizes);
  return sizes == size * 0x0001'0001'0001'0001u && _mm_movemask_epi8(_mm_cmpeq_epi32(first, expected)) == 0xFFFF;
}

// Of `count` that are so, 4 or 8, the depths in the low lanes; what is in further lanes is not stored.
[[gnu::target("avx2")]] inline void keep_together(const Covered& row, std::size_t i, std::size_t count, __m128i depths,
                                                  std::size_t columns, std::uint16_t* image) {
  const bool two_wide = (row.size[i] & 0xFF) == 2;
  const std::size_t high = row.size[i] >> 8u;
  if (two_wide) depths = _mm_min_epu16(depths, _mm_alignr_epi8(depths, _mm_set1_epi16(-1), 14));
  std::uint16_t* pixel = image + row.first[i];
  for (std::size_t v = 0; v < high; ++v, pixel += columns) {
    auto* at = reinterpret_cast<__m128i*>(pixel);
    if (count == 8)
      _mm_storeu_si128(at, _mm_min_epu16(_mm_loadu_si128(at), depths));
    else
      _mm_storel_epi64(at, _mm_min_epu16(_mm_loadl_epi64(at), depths));
    if (two_wide) keep(pixel[count], row.less_1[i + count - 1]);
  }
}

}  // namespace

[[gnu::target("avx2")]] void keep_simd(const Covered& row, std::size_t columns, std::uint16_t* image) {
  const std::size_t n = row.first.size();
  std::size_t i = 0;
  while (i + 4 <= n) {
    const auto* depths = reinterpret_cast<const __m128i*>(&row.less_1[i]);
    if (!four_beside_each_other(row, i)) {
      keep_some(row, i, i + 4, columns, image);
      i += 4;
    } else if (i + 8 <= n && four_beside_each_other(row, i + 4) && row.first[i + 4] == row.first[i] + 4 &&
               row.size[i + 4] == row.size[i]) {
      keep_together(row, i, 8, _mm_loadu_si128(depths), columns, image);
      i += 8;
    } else {
      keep_together(row, i, 4, _mm_loadl_epi64(depths), columns, image);
      i += 4;
    }
  }
  keep_some(row, i, n, columns, image);
}

#else

void keep_simd(const Covered& row, std::size_t columns, std::uint16_t* image) { keep_plain(row, columns, image); }

#endif

}  // namespace onemap::hal::imaging::nearest
