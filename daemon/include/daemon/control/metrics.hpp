#pragma once
#include <string>

#include "daemon/control/robot_facts.hpp"

namespace onemap::daemon {

// Everything that can be counted of a robot, as Prometheus text; for onemapctl and for the HTTP port alike. Names begin
// with onemap_; counters end in _total and count from the daemon's start.
std::string metrics_text(const RobotFacts& facts);

}  // namespace onemap::daemon
