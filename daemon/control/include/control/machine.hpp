#pragma once
#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace onemap::control {

// What a program ended with, and all that it said.
struct Told {
  static constexpr int kTooLong = 124;  // it was stopped, for it did not end
  int status = 0;
  std::string text;
};

// The machine around onemapctl: where a doctor looks while no daemon answers.
struct Machine {
  std::string root;           // before each path; empty: this machine's own
  uid_t user = 0;             // whom the daemon runs as
  std::vector<gid_t> groups;  // his
  std::function<std::optional<Told>(const std::string& options)> onemapd;  // nothing: it is not found
};

// Root asks about the service, which runs as the user onemap with the group video, too; everybody else about a daemon
// of his own.
Machine this_machine();

}  // namespace onemap::control
