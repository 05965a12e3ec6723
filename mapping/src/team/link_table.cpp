#include "mapping/team/link_table.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

// What `author` last wrote about its pair with `other`, if it was about this life of the other.
const LinkRecord* written(const TeamMember& author, const RobotId& other_id, const TeamMember& other) {
  const auto at = author.links.find(other_id);
  const bool present = at != author.links.end() && at->second.incarnation_other == other.incarnation;
  return present ? &at->second : nullptr;
}

std::uint64_t keyframes(const LinkRecord& link) { return std::uint64_t{link.keyframes_a} + link.keyframes_b; }

}  // namespace

const LinkRecord* link_between(const TeamLog& log, const RobotId& a, const RobotId& b) {
  const auto& [low_id, high_id] = std::minmax(a, b);
  const TeamMember *low = log.find(low_id), *high = log.find(high_id);
  if (low == nullptr || high == nullptr || low == high) return nullptr;
  const LinkRecord *by_low = written(*low, high_id, *high), *by_high = written(*high, low_id, *low);
  if (by_high == nullptr || by_low == nullptr) return by_low != nullptr ? by_low : by_high;
  const bool really_here =
      by_high->keyframes_a <= low->keyframes.size() && by_high->keyframes_b <= high->keyframes.size();
  return really_here && keyframes(*by_high) > keyframes(*by_low) ? by_high : by_low;
}

bool covers(const LinkRecord& link, const TeamMember& a, const TeamMember& b) {
  return link.keyframes_a == a.keyframes.size() && link.keyframes_b == b.keyframes.size();
}

std::vector<LinkRecord> counting_links(const TeamLog& log) {
  std::vector<LinkRecord> out;
  const std::vector<RobotId> ids = log.robots();
  for (std::size_t i = 0; i < ids.size(); ++i)
    for (std::size_t j = i + 1; j < ids.size(); ++j)
      if (const LinkRecord* link = link_between(log, ids[i], ids[j])) out.push_back(*link);
  return out;
}

const LinkRecord* own_loops(const TeamMember& member, const RobotId& robot) { return written(member, robot, member); }

std::vector<LinkRecord> counting_loops(const TeamLog& log) {
  std::vector<LinkRecord> out;
  for (const RobotId& robot : log.robots())
    if (const LinkRecord* loops = own_loops(*log.find(robot), robot)) out.push_back(*loops);
  return out;
}

}  // namespace onemap::mapping
