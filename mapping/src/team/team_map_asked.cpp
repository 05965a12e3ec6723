// What people ask of a TeamMap, and rule.
#include <algorithm>
#include <tuple>

#include "mapping/team/link_table.hpp"
#include "mapping/team/team_map.hpp"

namespace onemap::mapping {

Result<Why> TeamMap::why(const RobotId& a, const RobotId& b) const {
  for (const RobotId& robot : {a, b})
    if (const TeamMember* member = log_.find(robot); member == nullptr || !member->counts())
      return Error{"robot " + robot.name(), "is not known here"};
  Why out = mapping::why(log_, solution(), a, b);
  for (const auto& [other, link] : unwritten_) {
    if (std::minmax(a, b) != std::minmax(self_, other.robot)) continue;
    WhyPair looked;
    std::tie(looked.a, looked.b) = std::minmax(log_.own_chain(), other);
    looked.link = link;
    looked.verdict.a = looked.a;
    looked.verdict.b = looked.b;
    const auto same = [&](const WhyPair& pair) { return pair.a == looked.a && pair.b == looked.b; };
    const auto known = std::ranges::find_if(out.pairs, same);
    if (known == out.pairs.end())
      out.pairs.push_back(std::move(looked));
    else if (!known->link)
      known->link = link;
  }
  std::ranges::sort(out.pairs, {}, [](const WhyPair& pair) { return std::pair{pair.a, pair.b}; });
  return out;
}

Result<std::size_t> TeamMap::rule(const RobotId& a, const RobotId& b, bool apart) {
  auto all = why(a, b);
  if (!all) return all.error();
  std::size_t ruled = 0;
  for (const WhyPair& pair : all->pairs) {
    const bool is_apart = pair.ruling && pair.ruling->apart;
    const bool joins = pair.link && pair.link->reason == LinkReason::accepted && !pair.link->pairs.empty();
    if (is_apart == apart || (apart && !joins)) continue;
    const std::uint32_t turn = pair.ruling ? pair.ruling->turn + 1 : 1;
    if (turn > kMostTurns) continue;
    records_.push_back({Lane::poses, RecordKind::ruling, encode(RulingRecord{pair.a, pair.b, apart, turn})});
    ++ruled;
  }
  if (ruled > 0) return ruled;
  return Error{a.name() + " and " + b.name(), apart ? "no link joins them" : "nobody has taken their links back"};
}

std::string TeamMap::graph() const { return solution() != nullptr ? graph_text(log_, *solution()) : std::string(); }

std::vector<LinkRecord> TeamMap::links() const {
  std::vector<LinkRecord> out;
  for (const TeamLink& link : counting_links(log_)) out.push_back(*link.link);
  return out;
}

}  // namespace onemap::mapping
