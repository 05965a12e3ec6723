#include <cstdio>

#include "daemon/app.hpp"

int main(int argc, char** argv) {
  using namespace onemap::daemon;
  auto options = parse_daemon_options({argv + 1, argv + argc});
  if (!options.value) {
    std::fputs(options.text.c_str(), options.exit == Exit::done ? stdout : stderr);
    return static_cast<int>(options.exit);
  }
  StopSignals signals;
  Log log(options.value->id);
  App app(std::move(*options.value), log);
  return static_cast<int>(app.run(signals));
}
