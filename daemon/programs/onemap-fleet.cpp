#include <filesystem>

#include "daemon/command_line.hpp"
#include "daemon/fleet/fleet.hpp"

int main(int argc, char** argv) {
  using namespace onemap::daemon;
  return run_program("onemap-fleet", argc, argv, [](const std::vector<std::string>& arguments) {
    StopSignals signals;
    auto options = parse_fleet_options(arguments);
    if (!options.value) return end(options);
    const auto self = std::filesystem::read_symlink("/proc/self/exe");
    Fleet fleet(std::move(*options.value), (self.parent_path() / "onemapd").string());
    return static_cast<int>(fleet.run(signals));
  });
}
