#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "mapping/team/atlas.hpp"

namespace onemap::test {

// All robots' submaps, in any order, into the atlas at once.
inline void rebuild(mapping::Atlas& atlas, const mapping::SolutionRecord& solution,
                    std::span<const mapping::Atlas::Submap> submaps) {
  using Submap = mapping::Atlas::Submap;
  atlas.begin(solution);
  std::vector<Submap> sorted(submaps.begin(), submaps.end());
  std::ranges::stable_sort(sorted, {}, &Submap::robot);
  for (auto first = sorted.begin(); first != sorted.end();) {
    const auto last = std::find_if_not(first, sorted.end(), [&](const Submap& s) { return s.robot == first->robot; });
    atlas.add(first->robot, {first, last});
    first = last;
  }
}

}  // namespace onemap::test
