#pragma once
#include <cstdint>
#include <vector>

#include "mapping/records/frontier.hpp"

namespace onemap::mapping {

// What a robot said last of how far records count, of its present Solution: the newest, and earlier ones the sparser
// the older they are. A robot that records reach late makes the map of one that it holds; if only the newest counted,
// who lags by more than their interval would never have a map.
class RecentFrontiers {
 public:
  static constexpr std::size_t kMost = 12;

  void add(FrontierRecord frontier) {
    if (!kept_.empty() && kept_.back().frontier.solution != frontier.solution) kept_.clear();
    if (kept_.size() == kMost) thin();
    kept_.push_back({++said_, std::move(frontier)});
  }
  // The newest of this Solution for which holds(frontier); nullptr: none.
  template <class Holds>
  const FrontierRecord* newest(std::uint64_t solution, const Holds& holds) const {
    for (auto at = kept_.rbegin(); at != kept_.rend(); ++at)
      if (at->frontier.solution == solution && holds(at->frontier)) return &at->frontier;
    return nullptr;
  }

 private:
  struct Said {
    std::uint64_t number;
    FrontierRecord frontier;
  };
  // One goes whose neighbours are the nearest together for its age.
  void thin() {
    std::size_t least = 1;
    const auto gap = [&](std::size_t i) { return kept_[i + 1].number - kept_[i - 1].number; };
    const auto age = [&](std::size_t i) { return said_ + 1 - kept_[i].number; };
    for (std::size_t i = 2; i + 1 < kept_.size(); ++i)
      if (gap(i) * age(least) < gap(least) * age(i)) least = i;
    kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(least));
  }

  std::vector<Said> kept_;  // oldest first
  std::uint64_t said_ = 0;
};

}  // namespace onemap::mapping
