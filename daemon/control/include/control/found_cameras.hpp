#pragma once
#include <string>

#include "control/machine.hpp"
#include "control/protocol.hpp"
#include "hal/base/result.hpp"

namespace onemap::control {

// The cameras of this machine, as `onemapd --cameras --json` finds them: {"found": [{"address", "description",
// "abilities", "problem", "limits"}, ...], "auto": the address that auto opens, or null}. A program of its own looks,
// so a daemon that runs neither waits nor is disturbed; a driver that hangs ends with that program. An error when it
// cannot be run or says something else.
Result<Json> found_cameras(const Machine& machine);

// For people: what is there, what it can do, why one cannot be used or does less than it could, and what auto opens.
std::string found_cameras_words(const Json& found);

}  // namespace onemap::control
