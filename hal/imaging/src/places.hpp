#pragma once
#include <cstdint>
#include <span>
#include <vector>

// Where the disparities of a row go: the inner loop of TabledRegistration, and its twin of AVX2.
namespace onemap::hal::imaging::places {

// A disparity's depth less 1 (kNothing: none) in the low 16 bits, and in the high ones how far it moves to the right,
// in 1/256 of a column.
inline constexpr std::uint16_t kNothing = 65535;
inline constexpr std::int32_t kNoReading = kNothing;
inline std::int32_t reading(std::uint16_t mm, std::int16_t right) { return right * 65536 + (mm - 1); }

// How far a pixel is moved, whatever its depth, in the same unit; and the row that it comes to.
struct Moved {
  std::int16_t right = 0, row = -1;  // -1: nowhere
};

struct Table {
  std::vector<std::int32_t> readings;  // 2048, by disparity
  std::int32_t columns, pixels;        // of the image
  std::int32_t less;                   // what all places are less than their row and column say
};

struct Row {
  std::int32_t first;  // the row's first pixel
  std::span<const std::uint16_t> disparity;
  const Moved* moved;
};

// Of each of the row's pixels its place, which is always one in the image, and the depth less 1 that it gives there.
void find_plain(const Table& table, const Row& row, std::int32_t* place, std::uint16_t* less_1);
void find_simd(const Table& table, const Row& row, std::int32_t* place, std::uint16_t* less_1);  // simd_available()

}  // namespace onemap::hal::imaging::places
