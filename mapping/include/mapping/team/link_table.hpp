#pragma once
#include <vector>

#include "mapping/team/team_log.hpp"

// Which link of a pair of chains counts: a function of the records alone. Here is decided that two robots are linked.
namespace onemap::mapping {

// A link, and which lives it is of: a <= b, a = b for a chain's own loops. Lives as long as the log is not changed.
struct TeamLink {
  ChainId a, b;
  const LinkRecord* link = nullptr;
};

// The link between two chains, nullptr when nobody has looked. The lower one's own counts, unless the other one looked
// at more keyframes that are really here (it does when the lower one is gone, or an earlier life).
const LinkRecord* link_between(const TeamLog& log, const ChainId& a, const ChainId& b);

// Whether the link is from all keyframes of the two that are here.
bool covers(const LinkRecord& link, const TeamMember& a, const TeamMember& b);

// The links that count, accepted and refused, of the chains that count and that nobody ruled apart; sorted by pair.
std::vector<TeamLink> counting_links(const TeamLog& log);

// What a robot last wrote of the places that it came back to in this life; nullptr: nothing yet.
const LinkRecord* own_loops(const TeamMember& member, const RobotId& robot);
std::vector<TeamLink> counting_loops(const TeamLog& log);  // likewise; sorted by chain

}  // namespace onemap::mapping
