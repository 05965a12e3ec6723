#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config.hpp"

namespace onemap::daemon {

// What a program is started in, as far as the configuration asks for it; tests have their own.
struct Surroundings {
  std::string config_file = "/etc/onemap/onemap.toml";             // read when no other is named, if it is there
  std::function<std::string(const char*)> variable = environment;  // of the environment; empty: not there
  static std::string environment(const char* name);
};

// FILE.d/*.toml, by name: what somebody adds to FILE without changing it. No such folder: none. What begins with '.' is
// an editor's and left out.
Result<std::vector<std::string>> drop_ins(const std::string& file);

// Reads FILE and then its drop-ins over `config`; every error of all of them. must_exist: FILE was asked for, so it is
// an error when it is not there.
std::vector<Error> read_config_files(const std::string& file, bool must_exist, Config& config);

// Where a robot writes that was not told where: the service's state folder, or the user's. The origin is for people.
struct DefaultOut {
  std::string folder, origin;  // no folder: there is no such place
};
DefaultOut default_out(const Surroundings& surroundings);

}  // namespace onemap::daemon
