#pragma once
#include <optional>
#include <string>
#include <vector>

#include "daemon/config.hpp"

namespace onemap::daemon {

// What the programs exit with.
enum class Exit : int {
  done = 0,        // the work was done and everything is written
  failed = 1,      // something could not be done; the last lines on stderr say what and why
  usage = 2,       // bad command line, configuration file or camera address
  unfinished = 3,  // stopped, or out of time, before the work was done; what there was is written
};

// What a command line says: go on with a value, or end now (help was asked for, or it was wrong) with the text.
template <class T>
struct Parsed {
  std::optional<T> value;
  Exit exit = Exit::done;
  std::string text;
};

// onemapd's command line; the file of --config is read first and the command line goes over it.
Parsed<Config> parse_daemon_options(const std::vector<std::string>& arguments);

}  // namespace onemap::daemon
