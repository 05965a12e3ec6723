#include "team/place_search.hpp"

#include <bit>

#include "local/twin.hpp"

namespace onemap::mapping::place {

namespace {

ONEMAP_TWIN_BODY void search_body(Search& search) {
  search.found = 0;
  for (std::size_t t = 0; t < PlaceIndex::kTables; ++t)
    for (std::uint32_t at = search.heads[t]; at != 0;) {
      const PlaceIndex::Entry& entry = search.entries[at - 1];
      const std::int32_t distance = hamming_distance(entry.bits, search.bits);
      if (distance <= search.max_distance) search.near[search.found++] = {at - 1, distance};
      at = entry.next[t];
    }
}

}  // namespace

ONEMAP_TWIN(search, (Search & search), (search))

std::uint32_t log2_fixed(std::uint64_t x) {
  constexpr int kFractionBits = 10;
  const int whole = std::bit_width(x) - 1;
  std::uint64_t mantissa = whole > 31 ? x >> (whole - 31) : x << (31 - whole);  // 1 .. 2 in units of 2^-31
  std::uint32_t log = static_cast<std::uint32_t>(whole);
  for (int i = 0; i < kFractionBits; ++i) {
    mantissa = (mantissa * mantissa) >> 31;
    const bool beyond_two = mantissa >> 32 != 0;
    log = 2 * log + (beyond_two ? 1 : 0);
    if (beyond_two) mantissa >>= 1;
  }
  return log;
}

}  // namespace onemap::mapping::place
