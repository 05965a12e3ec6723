#include "places.hpp"

#include "hal/base/twin.hpp"

namespace onemap::hal::imaging::places {

namespace {

// No branch in the loop, so that the compiler makes vectors of it.
ONEMAP_TWIN_BODY void find_body(const Table& table, const Row& row, std::int32_t* __restrict place,
                                std::uint16_t* __restrict less_1) {
  const std::int32_t columns = table.columns, pixels = table.pixels, less = table.less, first = row.first;
  const std::int32_t* __restrict readings = table.readings.data();
  const std::uint16_t* __restrict disparity = row.disparity.data();
  const Moved* __restrict moved = row.moved;
  const auto n = static_cast<std::int32_t>(row.disparity.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t reading = readings[disparity[i]];
    // A quotient, as C has it: towards 0.
    const std::int32_t right = 256 * i + moved[i].right + (reading >> 16);
    const std::int32_t column = (right + ((right >> 31) & 255)) >> 8;
    const std::int32_t at = moved[i].row * columns + column - less;
    // Negative when one of them is.
    const std::int32_t fits = column | (columns - 1 - column) | at | (pixels - 1 - at) | moved[i].row;
    const std::int32_t nowhere = fits >> 31;  // all bits, or none
    place[i] = nowhere != 0 ? first + i : at;
    less_1[i] = static_cast<std::uint16_t>(reading | nowhere);
  }
}

}  // namespace

ONEMAP_TWIN(find, (const Table& table, const Row& row, std::int32_t* place, std::uint16_t* less_1),
            (table, row, place, less_1))

}  // namespace onemap::hal::imaging::places
