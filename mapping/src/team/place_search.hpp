#pragma once
#include "mapping/team/place_index.hpp"

namespace onemap::mapping::place {

struct Near {  // not cleared: an array of them is made for each feature
  std::uint32_t entry;
  std::int32_t distance;
};

// One feature's walk through its bucket of each table. What is near comes once for each table that has it.
struct Search {
  const PlaceIndex::Entry* entries = nullptr;
  std::array<std::uint32_t, PlaceIndex::kTables> heads{};
  DescriptorBits bits{};
  std::int32_t max_distance = 0;
  std::size_t found = 0;
  std::array<Near, PlaceIndex::kTables * PlaceIndex::kMaxBucket> near;
};
void search_plain(Search& search);
void search_simd(Search& search);

// log2 of x > 0, times 1024 and cut: by squaring, so that it is the same on every machine.
std::uint32_t log2_fixed(std::uint64_t x);

}  // namespace onemap::mapping::place
