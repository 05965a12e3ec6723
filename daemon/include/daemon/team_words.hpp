#pragma once
#include <string>

#include "daemon/log.hpp"
#include "mapping/team/team_event.hpp"
#include "mapping/team/team_log.hpp"

namespace onemap::daemon {

// Why a link was refused, with what was measured, for people; "accepted" otherwise.
std::string link_words(const mapping::LinkRecord& link);

// "robot1" for its present life, "robot1.17" for an earlier one that has the number 17.
std::string chain_name(const mapping::TeamLog& log, const mapping::ChainId& chain);

// What happened in the team as lines for people. The names in it are checked names; what robots say of themselves is
// made printable.
void say(const mapping::TeamEvent& event, Log& log);

}  // namespace onemap::daemon
