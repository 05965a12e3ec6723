#include "sideways.hpp"

#include <algorithm>

namespace onemap::hal::imaging::sideways {

namespace {

// No branch and no call in the loop, so that the compiler makes vectors of it.
ONEMAP_TWIN_BODY void find_body(const Rig& rig, std::span<const std::uint16_t> readings, Covered& out) {
  std::uint16_t* __restrict first = out.first.data(), * __restrict wide = out.wide.data(),
                * __restrict less_1 = out.less_1.data();
  const std::uint16_t* __restrict depth = readings.data();
  const float* __restrict column = rig.column.data();
  const float metres = rig.metres, offset = rig.offset_m, shift = rig.shift, half = rig.half, scale = rig.scale;
  const float nearest = rig.nearest_m, too_far = rig.too_far, width = static_cast<float>(rig.columns);
  const std::int32_t least = rig.least, last = rig.columns - 1;
  const auto n = static_cast<std::int32_t>(readings.size());
  std::int32_t some = 0, seen = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const float z = static_cast<float>(depth[i]) * metres + offset;
    std::int32_t begin, end;
    footprints::centres_around(column[i] + shift / (z > nearest ? z : nearest), half, width, begin, end);
    const auto value = static_cast<std::int32_t>(std::min(std::max(0.0f, z * scale + 0.5f), too_far));
    const std::int32_t covers = end - begin;
    // Negative when one of them is.
    const std::int32_t fits = (static_cast<std::int32_t>(depth[i]) - 1) | (covers - 1) |
                              (footprints::kWidest_px - covers) | (value - least) | (65535 - value);
    const std::int32_t nowhere = fits >> 31;  // all bits, or none
    // Such lie apart: a column that all share would have each wait for the one before.
    first[i] = static_cast<std::uint16_t>(nowhere != 0 ? std::min(i, last) : begin);
    wide[i] = static_cast<std::uint16_t>(nowhere != 0 ? 1 : covers);
    less_1[i] = static_cast<std::uint16_t>((value - 1) | nowhere);
    some += depth[i] != 0 ? 1 : 0;
    seen += 1 + nowhere;
  }
  out.readings = some;
  out.seen = seen;
}

ONEMAP_TWIN_BODY void merge_body(const std::uint16_t* __restrict line, std::size_t columns,
                                 std::uint16_t* __restrict row) {
  for (std::size_t i = 0; i < columns; ++i) row[i] = std::min(row[i], line[i]);
}

void nearer(std::uint16_t& pixel, std::uint16_t less_1) { pixel = std::min(pixel, less_1); }

// Without a loop and a branch: a column may be looked at twice, or thrice.
template <int most>
void keep_narrow(const Covered& row, std::uint16_t* __restrict line) {
  const std::uint16_t *first = row.first.data(), *wide = row.wide.data(), *less_1 = row.less_1.data();
  for (std::size_t i = 0; i < row.first.size(); ++i) {
    std::uint16_t* pixel = line + first[i];
    nearer(pixel[0], less_1[i]);
    if constexpr (most > 2) nearer(pixel[wide[i] / 2u], less_1[i]);
    nearer(pixel[wide[i] - 1u], less_1[i]);
  }
}

}  // namespace

void keep(const Covered& row, std::size_t most, std::uint16_t* line) {
  if (most <= 2) return keep_narrow<2>(row, line);
  if (most == 3) return keep_narrow<3>(row, line);
  for (std::size_t i = 0; i < row.first.size(); ++i)
    for (std::size_t u = 0; u < row.wide[i]; ++u) nearer(line[row.first[i] + u], row.less_1[i]);
}

ONEMAP_TWIN(find, (const Rig& rig, std::span<const std::uint16_t> depth, Covered& out), (rig, depth, out))
ONEMAP_TWIN(merge, (const std::uint16_t* line, std::size_t columns, std::uint16_t* row), (line, columns, row))

}  // namespace onemap::hal::imaging::sideways
