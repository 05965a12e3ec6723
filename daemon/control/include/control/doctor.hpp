#pragma once
#include <string>
#include <vector>

#include "control/protocol.hpp"

namespace onemap::control {

// What a client can see of a daemon's surroundings by itself: its socket's permissions and the system's clock. Each
// {"about", "ok", "text", "advice"}.
std::vector<Json> own_findings(const std::string& socket);
Json look_at_clock();

}  // namespace onemap::control
