#pragma once
#include "daemon/control/control_actions.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

// WHY, UNMERGE and MERGE, which the team's thread answers between two pieces of its work.
ControlActions team_actions(Team& team);

}  // namespace onemap::daemon
