#include <cstdio>

#include "daemon/app.hpp"

namespace {

using namespace onemap::daemon;

Exit run(const std::vector<std::string>& arguments) {
  StopSignals signals;  // first: whoever is told to stop writes what there is, from here on
  auto options = parse_daemon_options(arguments);
  if (!options.value) {
    (void)std::fputs(options.text.c_str(), options.exit == Exit::done ? stdout : stderr);
    return options.exit;
  }
  Log log(options.value->id);
  App app(std::move(*options.value), log);
  return app.run(signals);
}

}  // namespace

int main(int argc, char** argv) try {
  return static_cast<int>(run({argv + 1, argv + argc}));
} catch (...) {  // before the threads began, or when there was no memory for an error
  (void)std::fprintf(stderr, "onemapd: %s\n", what_of_current_exception().c_str());
  return static_cast<int>(Exit::failed);
}
