#include "hal/imaging/tabled_registration.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <vector>

#include "disparity11.hpp"
#include "hal/base/twin.hpp"
#include "places.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr std::int32_t kColumn = 256;  // the tables' unit
constexpr std::uint16_t kNoDepth_mm = 10000;

bool fits_16_bits(std::int64_t value) {
  return value >= std::numeric_limits<std::int16_t>::min() && value <= std::numeric_limits<std::int16_t>::max();
}

// By disparity. Depths grow with it up to the horizon; what tables say behind it is no depth.
std::vector<std::int32_t> readings_of(const FactoryTables& tables) {
  std::vector<std::int32_t> out(disparity11::kValues, places::kNoReading);
  std::uint16_t last = 0;
  for (std::size_t d = 0; d < std::min(out.size(), tables.mm_of_disparity.size()); ++d) {
    const std::uint16_t mm = tables.mm_of_disparity[d];
    if (mm < last || mm >= kNoDepth_mm) break;
    last = mm;
    if (mm == 0 || mm >= tables.shift_of_mm.size() || !fits_16_bits(tables.shift_of_mm[mm])) continue;
    out[d] = places::reading(mm, static_cast<std::int16_t>(tables.shift_of_mm[mm]));
  }
  return out;
}

}  // namespace

struct TabledRegistration::Parts {
  Parts(ImageSize of, const FactoryTables& tables)
      : size(of),
        table{readings_of(tables), of.width, static_cast<std::int32_t>(of.pixels()), tables.less},
        moved(of.pixels()),
        disparity(static_cast<std::size_t>(of.width)),
        place(static_cast<std::size_t>(of.width)),
        less_1(static_cast<std::size_t>(of.width)) {
    for (std::size_t i = 0; i < std::min(moved.size(), tables.places.size() / 2); ++i) {
      const std::int64_t column = static_cast<std::int64_t>(i % place.size()) * kColumn;
      const std::int64_t right = tables.places[2 * i] - column, row = tables.places[2 * i + 1];
      if (fits_16_bits(right) && row >= 0 && row < of.height)
        moved[i] = {static_cast<std::int16_t>(right), static_cast<std::int16_t>(row)};
    }
  }
  const ImageSize size;
  const places::Table table;
  std::vector<places::Moved> moved;  // of each pixel
  std::vector<std::uint16_t> disparity;
  std::vector<std::int32_t> place;
  std::vector<std::uint16_t> less_1;
  const bool simd = simd_available();
};

TabledRegistration::TabledRegistration(ImageSize size, const FactoryTables& tables)
    : parts_(std::make_unique<Parts>(size, tables)) {
  assert(size.width % static_cast<int>(disparity11::kPixels) == 0);
}

TabledRegistration::~TabledRegistration() = default;

Status TabledRegistration::apply(std::span<const std::uint8_t> packed, std::span<std::uint16_t> registered) {
  Parts& p = *parts_;
  assert(registered.size() == p.size.pixels());
  const std::size_t width = p.place.size(), row_bytes = width / disparity11::kPixels * disparity11::kBytes;
  if (Status status = disparity11::check(packed, p.size.pixels()); !status) return status;
  std::ranges::fill(registered, places::kNothing);
  for (std::size_t at = 0; at < registered.size(); at += width, packed = packed.subspan(row_bytes)) {
    disparity11::unpack(packed.data(), p.disparity, [](std::uint16_t value) { return value; });
    const places::Row row{static_cast<std::int32_t>(at), p.disparity, &p.moved[at]};
    (p.simd ? places::find_simd : places::find_plain)(p.table, row, p.place.data(), p.less_1.data());
    for (std::size_t i = 0; i < width; ++i) {
      std::uint16_t& pixel = registered[static_cast<std::size_t>(p.place[i])];
      pixel = std::min(pixel, p.less_1[i]);
    }
  }
  for (std::uint16_t& pixel : registered) ++pixel;  // nothing becomes 0
  return success();
}

}  // namespace onemap::hal::imaging
