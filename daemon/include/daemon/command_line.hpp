#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/options.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace onemap::daemon {

// What every program's command line has: --help, --version, and errors that say where to read on. Nothing: go on;
// otherwise end with this.
std::optional<Ending> parse_command_line(CLI::App& app, const std::vector<std::string>& arguments);

// `PROGRAM: what`, for stderr, whatever it quotes.
std::string complaint(const std::string& program, const std::string& what);

// Says what a program ends with, help on stdout and complaints on stderr, and returns the exit status.
int end(const Ending& ending);

// A program's main: what the body throws is said and is a failure, and so is a standard output that takes nothing.
int run_program(const std::string& name, int argc, char** argv,
                const std::function<int(const std::vector<std::string>&)>& body);

}  // namespace onemap::daemon
