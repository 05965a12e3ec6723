#include "mapping/team/election.hpp"

#include <algorithm>
#include <map>

namespace onemap::mapping {

std::vector<std::vector<RobotId>> islands(std::span<const RobotId> robots, std::span<const LinkRecord> links) {
  std::map<RobotId, RobotId> name;  // of each robot's island: its lowest id
  for (const RobotId& robot : robots) name.emplace(robot, robot);
  for (const LinkRecord& link : links) {
    const auto a = name.find(link.a), b = name.find(link.b);
    if (link.reason != LinkReason::accepted || a == name.end() || b == name.end()) continue;
    const auto [low, high] = std::minmax({a->second, b->second});
    for (auto& [robot, island] : name)
      if (island == high) island = low;
  }
  std::map<RobotId, std::vector<RobotId>> by_name;
  for (const auto& [robot, island] : name) by_name[island].push_back(robot);
  std::vector<std::vector<RobotId>> out;
  out.reserve(by_name.size());
  for (auto& [island, members] : by_name) out.push_back(std::move(members));
  std::stable_sort(out.begin(), out.end(), [](const auto& x, const auto& y) { return x.size() > y.size(); });
  return out;
}

std::optional<RobotId> elect(const std::vector<std::vector<RobotId>>& islands,
                             const std::function<bool(const RobotId&)>& may_decide) {
  for (const auto& island : islands)
    if (const auto at = std::find_if(island.begin(), island.end(), may_decide); at != island.end()) return *at;
  return std::nullopt;
}

}  // namespace onemap::mapping
