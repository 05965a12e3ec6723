#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "footprints.hpp"

// Which columns of a row the readings of a row cover, and what is nearest there: the inner loops of ByLines.
namespace onemap::hal::imaging::sideways {

// What all rows have in common.
struct Rig {
  std::vector<float> column;  // of each of a row's pixels, the column that it would come to from infinity
  float metres, offset_m;     // of a depth value, and added to it
  float shift;                // columns to the right, times metres
  float half;                 // of the columns that a reading covers
  float scale;                // colour's depth values of a metre
  float nearest_m, too_far;
  std::int32_t least, columns;
};

// Of each reading the first column and how many there are, 1 to footprints::kWidest_px, and its depth there less 1.
// Where there is none that is 65535, at one of the line's columns.
struct Covered {
  explicit Covered(std::size_t width) : first(width), wide(width), less_1(width) {}
  std::vector<std::uint16_t> first, wide, less_1;
  std::int32_t readings = 0, seen = 0;
};

void find_plain(const Rig& rig, std::span<const std::uint16_t> depth, Covered& out);
void find_simd(const Rig& rig, std::span<const std::uint16_t> depth, Covered& out);

// Of what covers a column of the line the nearest. `most`: no reading is wider.
void keep(const Covered& row, std::size_t most, std::uint16_t* line);

// Of the line and the row the nearer, column by column.
void merge_plain(const std::uint16_t* line, std::size_t columns, std::uint16_t* row);
void merge_simd(const std::uint16_t* line, std::size_t columns, std::uint16_t* row);

}  // namespace onemap::hal::imaging::sideways
