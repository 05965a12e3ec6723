#pragma once
#include <functional>

#include "daemon/control/command.hpp"

namespace onemap::daemon {

// What clients may ask the daemon to do, where it can: each gets the request and answers it later, from any thread, and
// returns at once. One that is not set is answered with "not available".
struct ControlActions {
  using Action = std::function<void(const Json& request, Later later)>;
  Action snapshot, save, load, record, why, unmerge, merge;
};

// The one table of what can be asked; to add something is a line here, a sentence in onemap-control.7, and a subcommand
// of onemapctl.
struct RobotFacts;
std::vector<Command> control_commands(const std::function<RobotFacts()>& facts, const ControlActions& actions);

// What WATCH can give.
inline constexpr std::string_view kWatchable[] = {"POSE", "EVENT", "PEERS", "STATUS"};

}  // namespace onemap::daemon
