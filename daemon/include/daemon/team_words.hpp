#pragma once
#include "daemon/log.hpp"
#include "mapping/team/team_event.hpp"

namespace onemap::daemon {

// Why a link was refused, for people; "accepted" otherwise.
const char* link_words(mapping::LinkReason reason);

// What happened in the team as lines for people. The names in it are checked names; what robots say of themselves is
// made printable.
void say(const mapping::TeamEvent& event, Log& log);

}  // namespace onemap::daemon
