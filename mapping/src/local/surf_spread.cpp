#include <algorithm>
#include <cmath>

#include "surf_internal.hpp"

namespace onemap::mapping::surf {

namespace {
constexpr int kCell_px = 80;
// Of what an even spread would give a cell: what its best are sure of, so that weak places stay held, and what it may
// take while others want room, so that one poster does not take all. Between the two the strongest win.
constexpr float kSureShare = 0.25f, kMostShare = 4.f;
}  // namespace

void Spread::reserve(int width, int height, std::size_t max_candidates) {
  cells_x_ = (width + kCell_px - 1) / kCell_px;
  const int cells_y = (height + kCell_px - 1) / kCell_px;
  taken.assign(static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_y), 0);
  chosen.reserve(max_candidates);
  spare.reserve(max_candidates);
}

// Moves the strongest candidates to `chosen` while their cell has less than `share`, and the others to `spare`.
void Spread::take(std::size_t share, std::size_t max_count, const std::vector<Candidate>& candidates) {
  spare.clear();
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
}

void Spread::select(std::size_t max_count, std::vector<Candidate>& candidates) {
  std::sort(candidates.begin(), candidates.end(), stronger);
  if (candidates.size() <= max_count) return;
  std::fill(taken.begin(), taken.end(), std::uint16_t{0});
  chosen.clear();
  const float even = static_cast<float>(max_count) / static_cast<float>(taken.size());
  const auto share = [&](float of_even) { return static_cast<std::size_t>(std::lround(of_even * even)); };
  for (const std::size_t most : {share(kSureShare), share(kMostShare), max_count}) {
    take(most, max_count, candidates);
    candidates.swap(spare);
  }
  std::sort(chosen.begin(), chosen.end(), stronger);
  candidates.swap(chosen);
}

}  // namespace onemap::mapping::surf
