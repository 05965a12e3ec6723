#include "daemon/map_agreement.hpp"

#include <algorithm>

namespace onemap::daemon {

namespace {
constexpr auto kFresh = std::chrono::seconds(5);
}

void MapAgreement::look(const TeamView& team, const RadioView& radio, Instant now) {
  differ_.clear();
  for (const auto& [robot, digest] : radio.map_digests) {
    if (team.gone.contains(robot) || !team.greeted.contains(robot)) continue;
    if (digest != 0 && std::ranges::find(team.digests, digest) != team.digests.end()) matched_[robot] = now;
    const auto last = matched_.find(robot);
    if (last == matched_.end() || now - last->second > kFresh) differ_.insert(robot);
  }
  agreed_ = team.digest != 0 && differ_.empty();
}

}  // namespace onemap::daemon
