#pragma once
#include <string>
#include <vector>

namespace onemap::control {

// What of the environment says where sockets are; empty: not set.
struct Environment {
  std::string runtime_directory;  // RUNTIME_DIRECTORY, of systemd; of a list the first
  std::string xdg_runtime_dir;    // XDG_RUNTIME_DIR, of a login
  std::string socket;             // ONEMAP_SOCKET, for clients
};
Environment environment();  // this process's

// Where a daemon's control socket is when nobody says: RUNTIME_DIRECTORY/control.sock; else
// XDG_RUNTIME_DIR/onemap/ID.sock; else OUT/control.sock.
std::string default_socket(const Environment& environment, const std::string& id, const std::string& out);

// Where a client looks when nobody says: ONEMAP_SOCKET alone if it is set, else the sockets that there are in
// RUNTIME_DIRECTORY, /run/onemap and its folders, and XDG_RUNTIME_DIR/onemap; sorted.
std::vector<std::string> likely_sockets(const Environment& environment, const std::string& run = "/run/onemap");

}  // namespace onemap::control
