// Sixteen pixels at a time: a half of each register holds eight, whose colours are worked out in 32 bits and put
// together again as bytes.
#include "yuv_row.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::hal::imaging::yuv {

#if defined(__x86_64__)
namespace {

constexpr std::size_t kAtOnce = 16;

// Two 16-bit numbers in each 32 bits.
[[gnu::target("avx2")]] inline __m256i pairs(int low, int high) {
  return _mm256_set1_epi32((high << 16) | (low & 0xFFFF));
}

[[gnu::target("avx2")]] inline __m256i in_both(__m128i half) { return _mm256_broadcastsi128_si256(half); }

// Of a half's eight pixels four, from `first`: Y with a colour byte of the pixel's, 0 for U and 2 for V.
[[gnu::target("avx2")]] inline __m128i taken(Order order, int first, int colour) {
  const auto y = [&](int i) { return static_cast<char>(2 * (first + i) + (order == Order::yuyv ? 0 : 1)); };
  const auto c = [&](int i) {
    return static_cast<char>(4 * ((first + i) / 2) + colour + (order == Order::yuyv ? 1 : 0));
  };
  return _mm_setr_epi8(y(0), -1, c(0), -1, y(1), -1, c(1), -1, y(2), -1, c(2), -1, y(3), -1, c(3), -1);
}

struct Four {  // pixels of each half, in 32 bits
  __m256i red, green, blue;
};

[[gnu::target("avx2")]] inline Four colours(__m256i y_u, __m256i y_v) {
  const __m256i zero = pairs(16, 128), half = _mm256_set1_epi32(kHalf);
  y_u = _mm256_sub_epi16(y_u, zero);
  y_v = _mm256_sub_epi16(y_v, zero);
  const auto sum = [&](__m256i a, __m256i b) __attribute__((target("avx2"), always_inline)) {
    return _mm256_srai_epi32(_mm256_add_epi32(_mm256_add_epi32(a, b), half), 8);
  };
  const __m256i none = _mm256_setzero_si256();
  return {sum(_mm256_madd_epi16(y_v, pairs(kY, kRedOfV)), none),
          sum(_mm256_madd_epi16(y_v, pairs(kY, kGreenOfV)), _mm256_madd_epi16(y_u, pairs(0, kGreenOfU))),
          sum(_mm256_madd_epi16(y_u, pairs(kY, kBlueOfU)), none)};
}

}  // namespace

[[gnu::target("avx2")]] void row_simd(Order order, const std::uint8_t* in, std::size_t width, std::uint8_t* rgb) {
  const __m256i first_u = in_both(taken(order, 0, 0)), first_v = in_both(taken(order, 0, 2)),
                last_u = in_both(taken(order, 4, 0)), last_v = in_both(taken(order, 4, 2));
  // Red and green of eight pixels are in one register, blue in another: their places among the 24 bytes.
  const __m256i rg_0 = in_both(_mm_setr_epi8(0, 8, -1, 1, 9, -1, 2, 10, -1, 3, 11, -1, 4, 12, -1, 5)),
                b_0 = in_both(_mm_setr_epi8(-1, -1, 0, -1, -1, 1, -1, -1, 2, -1, -1, 3, -1, -1, 4, -1)),
                rg_16 = in_both(_mm_setr_epi8(13, -1, 6, 14, -1, 7, 15, -1, -1, -1, -1, -1, -1, -1, -1, -1)),
                b_16 = in_both(_mm_setr_epi8(-1, 5, -1, -1, 6, -1, -1, 7, -1, -1, -1, -1, -1, -1, -1, -1));
  std::size_t x = 0;
  for (; x + kAtOnce <= width; x += kAtOnce, in += 2 * kAtOnce, rgb += 3 * kAtOnce) {
    const __m256i raw = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(in));
    const Four first = colours(_mm256_shuffle_epi8(raw, first_u), _mm256_shuffle_epi8(raw, first_v));
    const Four last = colours(_mm256_shuffle_epi8(raw, last_u), _mm256_shuffle_epi8(raw, last_v));
    const __m256i blue = _mm256_packs_epi32(first.blue, last.blue);
    const __m256i rg =
        _mm256_packus_epi16(_mm256_packs_epi32(first.red, last.red), _mm256_packs_epi32(first.green, last.green));
    const __m256i b = _mm256_packus_epi16(blue, blue);
    const __m256i start = _mm256_or_si256(_mm256_shuffle_epi8(rg, rg_0), _mm256_shuffle_epi8(b, b_0));
    const __m256i end = _mm256_or_si256(_mm256_shuffle_epi8(rg, rg_16), _mm256_shuffle_epi8(b, b_16));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(rgb), _mm256_castsi256_si128(start));
    _mm_storeu_si64(rgb + 16, _mm256_castsi256_si128(end));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(rgb + 24), _mm256_extracti128_si256(start, 1));
    _mm_storeu_si64(rgb + 40, _mm256_extracti128_si256(end, 1));
  }
  row_plain(order, in, width - x, rgb);
}

#else

void row_simd(Order order, const std::uint8_t* in, std::size_t width, std::uint8_t* rgb) {
  row_plain(order, in, width, rgb);
}

#endif

}  // namespace onemap::hal::imaging::yuv
