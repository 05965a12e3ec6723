#include "daemon/fleet/fleet_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>

#include "daemon/cameras.hpp"
#include "daemon/command_line.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kProgram = "onemap-fleet";
constexpr const char* kFooter =
    "Every robot is a real onemapd on this machine, found beside this program; only linked robots can talk.\n"
    "\nExamples:\n"
    "  onemap-fleet --simulate 3 --scene house --frames 510 --graph line --out OUT\n"
    "  onemap-fleet --robot replay:A --robot replay:B:0:300 --loss 10% --delay 20 --out OUT\n"
    "  onemap-fleet --robot replay:A --robot replay:B --matches-picture 50 --out OUT   # OUT/robot1/matches/...\n"
    "\nExit status:\n"
    "  0  done: every robot finished its recording and all hold the same map\n"
    "  1  something failed, or a robot did: the last lines on stderr say what and why; the others' work is written\n"
    "  2  bad command line or configuration file; nothing was started\n"
    "  3  stopped, out of time or without some robot before all agreed; what there was is written\n";

struct Given {
  std::vector<std::string> robots;
  std::size_t simulate = 0;
  std::string scene = "living-room", graph = "complete", loss = "0";
  double delay_ms = 0;
  std::size_t frames = 150;
  std::uint64_t seed = 1;
  FleetConfig config;
};

// CLI::Range lets through what is not a number.
CLI::Validator within(double least, double most) {
  return {[least, most](std::string& text) -> std::string {
            double value = 0;
            const char* const end = text.data() + text.size();
            const auto [stop, code] = std::from_chars(text.data(), end, value);
            if (code == std::errc{} && stop == end && value >= least && value <= most) return {};
            return fmt::format("'{}' is not a number from {} to {}", text, least, most);
          },
          fmt::format("{} to {}", least, most)};
}

void declare(CLI::App& app, Given& g) {
  auto* robots = app.add_option("--robot", g.robots, "a robot's camera address; may be given several times");
  robots->type_name("ADDRESS")->allow_extra_args(false);
  auto* simulate = app.add_option("--simulate", g.simulate, "so many robots with simulated cameras")->type_name("N");
  simulate->check(CLI::Range(1, 64))->excludes(robots);
  app.add_option("--scene", g.scene, "room of --simulate")->capture_default_str()->needs(simulate);
  app.add_option("--frames", g.frames, "frames a robot of --simulate")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000))
      ->needs(simulate);
  app.add_option("--graph", g.graph, "who hears whom: complete, line, ring, star, or a list such as 1-2,2-3")
      ->capture_default_str();
  app.add_option("--loss", g.loss, "of each direction of every link: 0.1 or 10%")
      ->type_name("P")
      ->capture_default_str();
  app.add_option("--delay", g.delay_ms, "of each direction of every link")->type_name("MS")->check(within(0, 10000));
  app.add_option("--seed", g.seed, "of the losses and of the simulated cameras")->capture_default_str();
  app.add_option("--speed", g.config.speed, "factor over the recordings' pace, or max: every frame")
      ->type_name("X|max")
      ->capture_default_str();
  app.add_option("--features", g.config.features, "surf or orb")->check(CLI::IsMember({"surf", "orb"}));
  app.add_option("--matches-picture", g.config.matches_picture,
                 "write a picture of each robot's feature matches every so many frames")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--config", g.config.robot_config, "TOML file for every robot, see onemapd --help-config")
      ->type_name("FILE");
  app.add_option("--team-key", g.config.team_key, "file with a team key (onemapctl team init --file FILE)")
      ->type_name("FILE");
  app.add_option("--timeout", g.config.timeout_s, "seconds until the robots are stopped, done or not")
      ->type_name("S")
      ->capture_default_str()
      ->check(within(1, 1e6));
  app.add_option("--out", g.config.out, "folder to write to; made when missing")->type_name("OUT")->required();
  app.footer(kFooter);
}

Result<FleetConfig> to_config(const Given& given) {
  FleetConfig config = given.config;
  config.cameras = given.robots;
  for (std::size_t i = 0; i < given.simulate; ++i)
    config.cameras.push_back(fmt::format("simulated:{}?robot={}&robots={}&frames={}&seed={}", given.scene, i + 1,
                                         given.simulate, given.frames, given.seed));
  if (config.cameras.empty()) return Error{"robots", "none given; say --robot ADDRESS or --simulate N"};
  for (const std::string& camera : config.cameras)
    if (auto status = hal::check_address(camera_backends(), camera); !status) return status.error();
  auto links = parse_graph(given.graph, config.cameras.size());
  if (!links) return links.error();
  config.links = std::move(*links);
  auto loss = parse_loss(given.loss);
  if (!loss) return loss.error();
  if (auto speed = parse_speed(config.speed); !speed) return speed.error();
  Config robot;
  if (!config.robot_config.empty())
    if (const auto errors = read_config_files(config.robot_config, true, robot); !errors.empty()) return errors.front();
  config.faults = {*loss, std::chrono::microseconds(static_cast<std::int64_t>(given.delay_ms * 1e3)), given.seed};
  return config;
}

}  // namespace

Result<double> parse_loss(const std::string& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  const bool percent = parsed.ptr + 1 == end && *parsed.ptr == '%';
  if (percent) value /= 100;
  if (parsed.ec != std::errc() || !(percent || parsed.ptr == end) || !(value >= 0) || value >= 1)
    return Error{"loss '" + text + "'", "expected a part such as 0.1 or 10%, from 0 to less than 1"};
  return value;
}

Parsed<FleetConfig> parse_fleet_options(const std::vector<std::string>& arguments) {
  CLI::App app("onemap-fleet - a whole team on one machine: real daemons, emulated links, one map", kProgram);
  Given given;
  declare(app, given);
  if (auto ending = parse_command_line(app, arguments)) return {std::move(*ending), std::nullopt};
  auto config = to_config(given);
  if (!config) return {{Exit::usage, complaint(kProgram, config.error().text())}, std::nullopt};
  return {{}, std::move(*config)};
}

std::string fleet_robot_name(std::size_t number) { return fmt::format("robot{}", number + 1); }

}  // namespace onemap::daemon
