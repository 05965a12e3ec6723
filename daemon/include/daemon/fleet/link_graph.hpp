#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// Two robots that can hear each other, by number from 0, first < second.
using FleetLink = std::pair<std::size_t, std::size_t>;

// `complete`, `line`, `ring`, `star` (robot 1 in the middle) or a list such as `1-2,2-3` (numbers from 1). Sorted, no
// link twice. A list may leave robots without any link.
Result<std::vector<FleetLink>> parse_graph(const std::string& text, std::size_t robots);

}  // namespace onemap::daemon
