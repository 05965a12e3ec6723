#pragma once
#include <optional>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/config_files.hpp"

namespace onemap::daemon {

// What the programs exit with.
enum class Exit : int {
  done = 0,        // the work was done and everything is written
  failed = 1,      // something could not be done; the last lines on stderr say what and why
  usage = 2,       // bad command line or configuration; nothing was opened or written
  unfinished = 3,  // stopped, or out of time, before the work was done; what there was is written
};

// How a program ends before it works: help or a version for stdout, or a complaint for stderr.
struct Ending {
  Exit exit = Exit::done;
  std::string text;
};

// What a command line says: a value to go on with, or how to end now.
template <class T>
struct Parsed : Ending {
  std::optional<T> value;
};

// onemapd's command line; the configuration's files are read first and the command line goes over them.
Parsed<Config> parse_daemon_options(const std::vector<std::string>& arguments, const Surroundings& surroundings = {});

// The same again under a running daemon (SIGHUP), started with these arguments. The error holds everything that is
// wrong; the daemon goes on with what it has. What may be taken over says plan_reload().
Result<Config> reload_config(const std::vector<std::string>& arguments, const Surroundings& surroundings = {});

}  // namespace onemap::daemon
