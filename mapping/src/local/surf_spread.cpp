#include <algorithm>

#include "surf_internal.hpp"

namespace onemap::mapping::surf {

namespace {
constexpr int kCell_px = 80;
}

void Spread::reserve(int width, int height, std::size_t max_candidates) {
  cells_x_ = (width + kCell_px - 1) / kCell_px;
  taken.assign(static_cast<std::size_t>(cells_x_ * ((height + kCell_px - 1) / kCell_px)), 0);
  chosen.reserve(max_candidates);
  spare.reserve(max_candidates);
}

void Spread::select(int width, std::size_t max_count, std::vector<Candidate>& candidates) {
  (void)width;
  std::sort(candidates.begin(), candidates.end(), stronger);
  if (candidates.size() <= max_count) return;
  std::fill(taken.begin(), taken.end(), std::uint16_t{0});
  chosen.clear();
  spare.clear();
  const std::size_t share = 1 + 3 * max_count / (2 * taken.size());
  for (const Candidate& c : candidates) {
    const int cell = static_cast<int>(c.y_px) / kCell_px * cells_x_ + static_cast<int>(c.x_px) / kCell_px;
    std::uint16_t& n = taken[static_cast<std::size_t>(cell)];
    if (n < share && chosen.size() < max_count) {
      ++n;
      chosen.push_back(c);
    } else {
      spare.push_back(c);
    }
  }
  const std::size_t missing = std::min(max_count - chosen.size(), spare.size());
  chosen.insert(chosen.end(), spare.begin(), spare.begin() + static_cast<std::ptrdiff_t>(missing));
  std::sort(chosen.begin(), chosen.end(), stronger);
  candidates.swap(chosen);
}

}  // namespace onemap::mapping::surf
