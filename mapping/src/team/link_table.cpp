#include "mapping/team/link_table.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

// What `author` last wrote about its pair with `other`.
const LinkRecord* written(const TeamMember& author, const ChainId& other) {
  const auto at = author.links.find(other);
  return at != author.links.end() ? &at->second : nullptr;
}

std::uint64_t keyframes(const LinkRecord& link) { return std::uint64_t{link.keyframes_a} + link.keyframes_b; }

}  // namespace

const LinkRecord* link_between(const TeamLog& log, const ChainId& a, const ChainId& b) {
  const auto& [low_id, high_id] = std::minmax(a, b);
  const TeamMember *low = log.find(low_id), *high = log.find(high_id);
  if (low == nullptr || high == nullptr || low == high) return nullptr;
  const LinkRecord *by_low = written(*low, high_id), *by_high = written(*high, low_id);
  if (by_high == nullptr || by_low == nullptr) return by_low != nullptr ? by_low : by_high;
  const bool really_here =
      by_high->keyframes_a <= low->keyframes.size() && by_high->keyframes_b <= high->keyframes.size();
  return really_here && keyframes(*by_high) > keyframes(*by_low) ? by_high : by_low;
}

bool covers(const LinkRecord& link, const TeamMember& a, const TeamMember& b) {
  return link.keyframes_a == a.keyframes.size() && link.keyframes_b == b.keyframes.size();
}

std::vector<TeamLink> counting_links(const TeamLog& log) {
  std::vector<TeamLink> out;
  const std::vector<ChainId> ids = log.chains();
  for (std::size_t i = 0; i < ids.size(); ++i)
    for (std::size_t j = i + 1; j < ids.size(); ++j)
      if (const LinkRecord* link = link_between(log, ids[i], ids[j]); link && !log.rulings().apart(ids[i], ids[j]))
        out.push_back({ids[i], ids[j], link});
  return out;
}

const LinkRecord* own_loops(const TeamMember& member, const RobotId& robot) {
  return written(member, {robot, member.incarnation});
}

std::vector<TeamLink> counting_loops(const TeamLog& log) {
  std::vector<TeamLink> out;
  for (const ChainId& chain : log.chains())
    if (const LinkRecord* loops = own_loops(*log.find(chain), chain.robot); loops && !log.rulings().apart(chain, chain))
      out.push_back({chain, chain, loops});
  return out;
}

}  // namespace onemap::mapping
