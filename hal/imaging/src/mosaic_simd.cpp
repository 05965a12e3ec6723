// Thirty-two pixels at a time, all in bytes: every pixel gets all three means, and of each what its place in the mosaic
// asks for is kept.
#include "mosaic_row.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace onemap::hal::imaging::mosaic {

#if defined(__x86_64__)
namespace {

constexpr std::size_t kAtOnce = 32;

[[gnu::target("avx2")]] inline __m256i load(const std::uint8_t* at) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
}

// (a + b + c + d + 2) / 4 of bytes. The mean of two means is 1 too much where one of the two was rounded up and their
// sum is odd, which rounds up once more.
[[gnu::target("avx2")]] inline __m256i mean(__m256i a, __m256i b, __m256i c, __m256i d) {
  const __m256i ab = _mm256_avg_epu8(a, b), cd = _mm256_avg_epu8(c, d);
  const __m256i rounded = _mm256_or_si256(_mm256_xor_si256(a, b), _mm256_xor_si256(c, d));
  const __m256i too_much = _mm256_and_si256(_mm256_and_si256(rounded, _mm256_xor_si256(ab, cd)), _mm256_set1_epi8(1));
  return _mm256_sub_epi8(_mm256_avg_epu8(ab, cd), too_much);
}

struct Planes {
  __m256i red, green, blue;
};

// The pixels from x, of which the first is green in the mosaic or not.
[[gnu::target("avx2")]] inline Planes planes(const Rows& rows, std::size_t x, bool odd_row, __m256i green) {
  const auto [above, here, below] = rows;
  const __m256i left = load(here + x - 1), own = load(here + x), right = load(here + x + 1);
  const __m256i up = load(above + x), down = load(below + x);
  const __m256i beside = _mm256_avg_epu8(left, right), over = _mm256_avg_epu8(up, down);
  const __m256i cross = mean(left, right, up, down);
  const __m256i corners = mean(load(above + x - 1), load(above + x + 1), load(below + x - 1), load(below + x + 1));
  const __m256i of_row = _mm256_blendv_epi8(own, beside, green), of_others = _mm256_blendv_epi8(corners, over, green);
  return {odd_row ? of_others : of_row, _mm256_blendv_epi8(cross, own, green), odd_row ? of_row : of_others};
}

// Where the bytes of a plane go among 48 of RGB: of `part`, a third of these, the ones of `channel`.
[[gnu::target("avx2")]] inline __m256i places(int part, int channel) {
  alignas(16) char from[16];
  for (int i = 0; i < 16; ++i) {
    const int at = 16 * part + i;
    from[i] = static_cast<char>(at % 3 == channel ? at / 3 : -1);
  }
  return _mm256_broadcastsi128_si256(_mm_load_si128(reinterpret_cast<const __m128i*>(from)));
}

}  // namespace

[[gnu::target("avx2")]] void row_simd(const Rows& rows, std::size_t width, bool odd_row, std::uint8_t* rgb) {
  side_pixel(rows, width, true, odd_row, rgb);
  // From x = 1 on: in an even row that is red.
  const __m256i green = _mm256_set1_epi16(static_cast<short>(odd_row ? 0x00FF : 0xFF00));
  __m256i place[3][3];
  for (int part = 0; part < 3; ++part)
    for (int channel = 0; channel < 3; ++channel) place[part][channel] = places(part, channel);
  std::size_t x = 1;
  for (; x + kAtOnce < width; x += kAtOnce) {
    const Planes of = planes(rows, x, odd_row, green);
    std::uint8_t* out = rgb + 3 * x;
    for (int part = 0; part < 3; ++part) {
      const __m256i both = _mm256_or_si256(
          _mm256_or_si256(_mm256_shuffle_epi8(of.red, place[part][0]), _mm256_shuffle_epi8(of.green, place[part][1])),
          _mm256_shuffle_epi8(of.blue, place[part][2]));
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 16 * part), _mm256_castsi256_si128(both));
      _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 48 + 16 * part), _mm256_extracti128_si256(both, 1));
    }
  }
  inner_plain(rows, x, width - 1, odd_row, rgb);
  side_pixel(rows, width, false, odd_row, rgb);
}

#else

void row_simd(const Rows& rows, std::size_t width, bool odd_row, std::uint8_t* rgb) {
  row_plain(rows, width, odd_row, rgb);
}

#endif

}  // namespace onemap::hal::imaging::mosaic
