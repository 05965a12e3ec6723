#include <cstdio>
#include <filesystem>

#include "daemon/fleet/fleet.hpp"

int main(int argc, char** argv) {
  using namespace onemap::daemon;
  auto options = parse_fleet_options({argv + 1, argv + argc});
  if (!options.value) {
    std::fputs(options.text.c_str(), options.exit == Exit::done ? stdout : stderr);
    return static_cast<int>(options.exit);
  }
  StopSignals signals;
  const auto self = std::filesystem::read_symlink("/proc/self/exe");
  Fleet fleet(std::move(*options.value), (self.parent_path() / "onemapd").string());
  return static_cast<int>(fleet.run(signals));
}
