#include "srgb.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace onemap::render {
namespace {

using Table = std::array<std::uint16_t, 256>;

Table make_table() {
  Table table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double s = static_cast<double>(i) / 255.0;
    const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    table[i] = static_cast<std::uint16_t>(std::lround(linear * 65535.0));
  }
  return table;
}

const Table& table() {
  static const Table kTable = make_table();
  return kTable;
}

}  // namespace

std::uint16_t linear_from_srgb(std::uint8_t value) { return table()[value]; }

std::uint8_t srgb_from_linear(std::uint16_t value) {
  const auto above = std::lower_bound(table().begin(), table().end(), value);
  if (above == table().begin()) return 0;
  if (above == table().end()) return 255;
  const auto below = above - 1;
  const bool nearer_below = value - *below < *above - value;
  return static_cast<std::uint8_t>((nearer_below ? below : above) - table().begin());
}

}  // namespace onemap::render
