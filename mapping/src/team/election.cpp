#include "mapping/team/election.hpp"

#include <algorithm>
#include <map>

namespace onemap::mapping {

std::vector<std::vector<ChainId>> islands(std::span<const ChainId> chains, std::span<const TeamLink> links) {
  std::map<ChainId, ChainId> name;  // of each chain's island: its lowest id
  for (const ChainId& chain : chains) name.emplace(chain, chain);
  for (const TeamLink& link : links) {
    const auto a = name.find(link.a), b = name.find(link.b);
    if (link.link->reason != LinkReason::accepted || a == name.end() || b == name.end()) continue;
    const auto [low, high] = std::minmax({a->second, b->second});
    for (auto& [chain, island] : name)
      if (island == high) island = low;
  }
  std::map<ChainId, std::vector<ChainId>> by_name;
  for (const auto& [chain, island] : name) by_name[island].push_back(chain);
  std::vector<std::vector<ChainId>> out;
  out.reserve(by_name.size());
  for (auto& [island, members] : by_name) out.push_back(std::move(members));
  std::stable_sort(out.begin(), out.end(), [](const auto& x, const auto& y) { return x.size() > y.size(); });
  return out;
}

std::optional<RobotId> elect(const std::vector<std::vector<ChainId>>& islands,
                             const std::function<bool(const ChainId&)>& may_decide) {
  for (const auto& island : islands)
    if (const auto at = std::find_if(island.begin(), island.end(), may_decide); at != island.end()) return at->robot;
  return std::nullopt;
}

}  // namespace onemap::mapping
