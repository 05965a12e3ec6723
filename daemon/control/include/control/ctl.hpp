#pragma once
#include <string>
#include <vector>

// onemapctl: asks a daemon, over its control socket, and shows people the answer.
namespace onemap::control {

// What onemapctl exits with.
enum class CtlExit : int {
  done = 0,
  refused = 1,    // the daemon could not or would not; doctor: something is wrong
  usage = 2,      // bad command line; nobody was asked
  no_daemon = 3,  // nobody answers
};

int run_ctl(int argc, char** argv);
std::vector<std::string> ctl_commands();  // as --help lists them
std::vector<std::string> ctl_options();   // of it and of all its commands, without "--", each once
std::string ctl_help();

}  // namespace onemap::control
