#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

#include "hal/base/result.hpp"

// Kinect v1's packed disparities: eight of 11 bits in eleven bytes, the high bits first.
namespace onemap::hal::imaging::disparity11 {

inline constexpr std::size_t kPixels = 8, kBytes = 11, kValues = 2048;

Status check(std::span<const std::uint8_t> packed, std::size_t pixels);  // whether there are so many, in whole eights

inline std::uint64_t big_endian(const std::uint8_t* at) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return __builtin_bswap64(value);
}

// From the first eight of the bytes and from the last eight: each has five whole ones.
inline std::array<std::uint16_t, kPixels> unpacked(const std::uint8_t* in) {
  const std::uint64_t first = big_endian(in), last = big_endian(in + kBytes - 8);
  const auto of = [](std::uint64_t bits, int shift) { return static_cast<std::uint16_t>(bits >> shift & 0x7FFu); };
  return {of(first, 53), of(first, 42), of(first, 31), of(last, 44),
          of(last, 33),  of(last, 22),  of(last, 11),  of(last, 0)};
}

// Each of whole eights of pixels; `of` makes of a disparity what is wanted.
template <class Of>
void unpack(const std::uint8_t* in, std::span<std::uint16_t> out, const Of& of) {
  for (std::size_t i = 0; i < out.size(); i += kPixels, in += kBytes) {
    const auto eight = unpacked(in);
    for (std::size_t k = 0; k < kPixels; ++k) out[i + k] = of(eight[k]);
  }
}

}  // namespace onemap::hal::imaging::disparity11
