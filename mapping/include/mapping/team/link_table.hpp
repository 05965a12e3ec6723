#pragma once
#include <vector>

#include "mapping/team/team_log.hpp"

// Which link of a pair of robots counts: a function of the records alone. Here is decided that two robots are linked.
namespace onemap::mapping {

// The link between the present lives of two robots, nullptr when nobody has looked. The lower robot's own counts,
// unless the other one looked at more keyframes that are really here (it does when the lower one is gone).
const LinkRecord* link_between(const TeamLog& log, const RobotId& a, const RobotId& b);

// Whether the link is from all keyframes of the two that are here.
bool covers(const LinkRecord& link, const TeamMember& a, const TeamMember& b);

// The links that count, accepted and refused, of the robots that count; sorted by pair.
std::vector<LinkRecord> counting_links(const TeamLog& log);

// What each robot that counts last wrote of the places that it came back to in its present life; nullptr: nothing yet.
const LinkRecord* own_loops(const TeamMember& member, const RobotId& robot);
std::vector<LinkRecord> counting_loops(const TeamLog& log);  // sorted by robot

}  // namespace onemap::mapping
