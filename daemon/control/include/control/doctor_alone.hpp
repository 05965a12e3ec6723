#pragma once
#include <vector>

#include "control/machine.hpp"
#include "control/protocol.hpp"
#include "hal/base/result.hpp"

namespace onemap::control {

// What is wrong when no daemon answers, for the reason `why`: its configuration, the folder that it writes to, the
// files of its keys, the nodes of cameras and what limits these, as far as they can be looked at. Each {"about", "ok",
// "text", "advice"}.
std::vector<Json> findings_without_daemon(const Error& why, const Machine& machine);

}  // namespace onemap::control
