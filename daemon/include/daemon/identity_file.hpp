#pragma once
#include <string>

#include "comms/identity.hpp"
#include "daemon/log.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

// The key pair of this robot, with which it signs its records and greets its team: OUT/identity (control/key_file.hpp),
// made when there is none. A robot whose folder cannot be written to has another key in each life, and says so. The
// error: the file says something else, or others may read it. It is left as it is, because a robot with another key is
// another robot to its team.
Result<comms::Identity> open_identity(const std::string& out, Log& log);

}  // namespace onemap::daemon
