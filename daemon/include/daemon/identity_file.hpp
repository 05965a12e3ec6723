#pragma once
#include <string>

#include "comms/identity.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

// The key pair of this robot, as FILE holds it: the 64 hexadecimal digits of its seed, for nobody's eyes but its own
// (0600). A file that is not there is made, with a seed from the kernel. One that says something else, or that others
// may read, is left as it is: the error says what to do about it, because a robot with another key is another robot to
// its team.
Result<comms::Identity> open_identity(const std::string& file);
Result<comms::Identity> read_identity(const std::string& file);  // the same, of a file that is there
// For a robot that can keep nothing: a key for this life alone.
comms::Identity passing_identity();

}  // namespace onemap::daemon
