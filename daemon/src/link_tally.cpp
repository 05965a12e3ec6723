#include "daemon/link_tally.hpp"

#include <algorithm>
#include <numeric>

namespace onemap::daemon {

namespace {
struct Add {
  LinkTally& tally;
  void operator()(const mapping::LinkLooked& e) const {
    const mapping::LinkRecord& link = e.link;
    if (link.a == link.b && link.incarnation_other == e.author.incarnation) {
      tally.own_loops += link.pairs.empty() ? 0 : 1;
      return;
    }
    ++tally.looked[std::min(static_cast<std::size_t>(link.reason), LinkTally::kReasons - 1)];
  }
  void operator()(const mapping::RecordRefused&) const { ++tally.records_refused; }
  void operator()(const mapping::DeciderPassedOver&) const { ++tally.deciders_passed_over; }
  void operator()(const mapping::MapFused&) const { ++tally.maps_fused; }
  template <class Other>
  void operator()(const Other&) const {}
};
}  // namespace

void LinkTally::add(const mapping::TeamEvent& event) { std::visit(Add{*this}, event); }

std::uint64_t LinkTally::proposed() const { return std::accumulate(looked.begin(), looked.end(), std::uint64_t{0}); }

std::string LinkTally::reason(std::size_t index) {
  static constexpr std::array kNames{"accepted",      "too_few_matches", "fundamental_failed", "depth_incoherent",
                                     "ransac_failed", "icp_failed",      "inconsistent",       "little_overlap",
                                     "seen_through",  "another_place",   "not_seen_again",     "later_version"};
  static_assert(kNames.size() == kReasons);
  return kNames.at(index);
}

}  // namespace onemap::daemon
