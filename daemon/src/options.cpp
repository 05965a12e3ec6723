#include "daemon/options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "daemon/cameras.hpp"

namespace onemap::daemon {

namespace {

struct Given {
  std::string config, id, camera, out, listen, speed, features;
  std::vector<std::string> peers;
  double linger_s = 0;
  int matches_picture = 0;
  bool once = false, cameras = false;
};

std::string footer() {
  std::string text = "Cameras:\n";
  for (const hal::Backend& backend : camera_backends())
    text += fmt::format("  {:<10} {}\n", backend.name, backend.description);
  return text +
         "\nWithout --listen and --peer the robot is alone. A recording without --once is played to its end, and the "
         "daemon\n"
         "then keeps serving what it knows until SIGTERM or SIGINT, which write everything and end it.\n"
         "\nExit status:\n"
         "  0  done: frames processed, everything written, and with --once in a team: all finished with equal maps\n"
         "  1  something failed; the last lines on stderr say what and why\n"
         "  2  bad command line, configuration file or camera address\n"
         "  3  --once, but stopped before the work was done; what there was is written\n";
}

void declare(CLI::App& app, Given& given) {
  app.add_option("--camera", given.camera, "camera address, for example replay:DIR; auto: the best that is there")
      ->type_name("ADDRESS");
  app.add_flag("--cameras", given.cameras, "list the cameras of this machine, and why one cannot be used");
  app.add_option("--config", given.config, "TOML file; the command line goes over it")->type_name("FILE");
  app.add_option("--id", given.id, "name of this robot, unique in the team")->type_name("NAME");
  app.add_option("--listen", given.listen, "UDP address to listen at; port 0: any")->type_name("ADDR:PORT");
  app.add_option("--peer", given.peers, "a neighbour; may be given several times")
      ->type_name("ADDR:PORT")
      ->allow_extra_args(false);
  app.add_flag("--once", given.once, "finish when the camera's stream is over and the team agrees");
  app.add_option("--speed", given.speed, "factor over the recording's pace, or max: every frame, as fast as it goes")
      ->type_name("X|max");
  app.add_option("--features", given.features, "surf or orb")->type_name("KIND");
  app.add_option("--linger", given.linger_s, "with --once: seconds to keep answering after all agree")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--matches-picture", given.matches_picture, "write a picture of the feature matches every N frames")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--out", given.out, "folder to write to; made when missing")->type_name("OUT");
  app.footer(footer());
}

Status apply(const CLI::App& app, const Given& given, Config& config) {
  const auto has = [&](const char* name) { return app.count(name) > 0; };
  if (has("--camera")) config.camera = given.camera;
  if (has("--id")) config.id = given.id;
  if (has("--out")) config.out = given.out;
  if (has("--listen")) config.listen = given.listen;
  if (has("--peer")) config.peers = given.peers;
  if (has("--once")) config.once = true;
  if (has("--linger")) config.linger_s = given.linger_s;
  if (has("--matches-picture")) config.matches_picture = given.matches_picture;
  if (has("--features")) {
    if (given.features != "surf" && given.features != "orb") return Error{"--features", "expected surf or orb"};
    config.mapper.features = given.features == "orb" ? mapping::DescriptorKind::orb : mapping::DescriptorKind::surf;
  }
  if (has("--speed")) {
    auto speed = parse_speed(given.speed);
    if (!speed) return speed.error();
    config.speed = *speed;
  }
  return success();
}

}  // namespace

Parsed<Config> parse_daemon_options(const std::vector<std::string>& arguments) {
  CLI::App app("onemapd - tracks an RGB-D camera, maps what it sees, and shares one map with its team", "onemapd");
  Given given;
  declare(app, given);
  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // as CLI11 wants them
    app.parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    return {std::nullopt, Exit::done, app.help()};
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, Exit::usage, std::string(error.what()) + "\nonemapd --help says what there is\n"};
  }
  if (given.cameras) return {std::nullopt, Exit::done, cameras_text(hal::list_cameras(camera_backends()))};
  Config config;
  Status status = given.config.empty() ? success() : load_config(given.config, config);
  if (status) status = apply(app, given, config);
  if (status) status = check_config(config);
  if (!status) return {std::nullopt, Exit::usage, status.error().text() + "\n"};
  return {std::move(config), Exit::done, {}};
}

}  // namespace onemap::daemon
