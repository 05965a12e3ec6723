#include "daemon/app.hpp"
#include "daemon/command_line.hpp"
#include "daemon/heap.hpp"

int main(int argc, char** argv) {
  using namespace onemap::daemon;
  give_memory_back();
  return run_program("onemapd", argc, argv, [](const std::vector<std::string>& arguments) {
    StopSignals signals(Hangup::reloads);  // before anything that could be stopped
    auto options = parse_daemon_options(arguments);
    if (!options.value) return end(options);
    Log log(options.value->id);
    App app(std::move(*options.value), log);
    app.on_reload([&] { app.reload(reload_config(arguments)); });
    return static_cast<int>(app.run(signals));
  });
}
