#pragma once
#include "daemon/log.hpp"
#include "mapping/team/team_event.hpp"

namespace onemap::daemon {

// What happened in the team as lines for people. The names in it are checked names; what robots say of themselves is
// made printable.
void say(const mapping::TeamEvent& event, Log& log);

}  // namespace onemap::daemon
