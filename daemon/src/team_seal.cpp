#include "daemon/team_seal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "comms/fingerprint.hpp"
#include "comms/udp/udp_port.hpp"
#include "control/key_file.hpp"
#include "daemon/addresses.hpp"
#include "daemon/identity_file.hpp"
#include "hal/base/file.hpp"

namespace onemap::daemon {

namespace {
bool there(const std::string& file) {
  std::error_code none;
  return std::filesystem::exists(file, none);
}

std::string hex(const comms::PublicKey& key) {
  std::string text;
  for (const auto byte : key) text += fmt::format("{:02x}", byte);
  return text;
}

bool read_key(const std::string& text, comms::PublicKey& key) {
  if (text.size() != 2 * key.size()) return false;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const char* const pair = text.data() + 2 * i;
    if (std::from_chars(pair, pair + 2, key[i], 16).ptr != pair + 2) return false;
  }
  return true;
}

void fill(std::span<std::uint8_t> bytes) {
  if (auto filled = control::fill_random(bytes); !filled) std::abort();  // nothing that would be safe to do is left
}

// A file that cannot be read is not passed over: with it goes what tells a robot from somebody who took its name.
Result<comms::Pins> read_pins(const std::string& file) {
  comms::Pins pins;
  if (!there(file)) return pins;
  const auto text = read_text_file(file, kSmallFileBytes * 4);
  if (!text) return text.error();
  std::istringstream in(*text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string name, key;
    comms::PublicKey read{};
    words >> name >> key;
    if (!RobotId::valid_name(name) || !read_key(key, read) || pins.all().size() >= comms::Pins::kMost)
      return Error{fmt::format("{}:{}", file, number), "expected a robot's name and its key; mend or remove the line"};
    pins.pin(RobotId::from_name(name), read);
  }
  return pins;
}

std::string what_to_do(const std::string& why) {
  return why +
         ", and this robot has no team key: it talks to its own machine only; `onemapctl team init` makes a key, "
         "`onemapctl team join` installs one";
}
}  // namespace

std::string team_key_file(const Config& config) {
  if (config.team_key_file == "none") return {};
  if (!config.team_key_file.empty()) return config.team_key_file;
  for (const std::string& file : {std::string(control::kTeamKeyFile), config.out + "/team.key"})
    if (there(file)) return file;
  return {};
}

Status check_reach_without_key(const Config& config) {
  for (const std::string& peer : config.peers) {
    const auto endpoint = comms::parse_endpoint(peer);
    if (endpoint && !is_loopback(*endpoint))
      return Error{"network.peers", what_to_do("\"" + peer + "\" is another machine")};
  }
  if (config.group.empty()) return success();
  const auto listen = comms::parse_endpoint(config.listen.empty() ? "0.0.0.0:0" : config.listen);
  if (listen && is_loopback(*listen)) return success();  // the group stays on this machine
  return Error{"network.group", what_to_do("\"" + config.group + "\" reaches other machines")};
}

Status check_keys(const Config& config) {
  const std::string file = team_key_file(config);
  if (!file.empty() && (!config.alone() || !config.team_key_file.empty()))
    if (const auto team = control::read_secret(file, control::kTeamKeyKind); !team)
      return Error{"team.key_file", team.error().text() +
                                        "; `onemapctl team join` installs a key, and team.key_file = \"none\" does "
                                        "without"};
  if (config.alone()) return success();
  if (const std::string own = config.out + "/identity"; there(own))
    if (const auto identity = read_identity(own); !identity) return identity.error();
  if (file.empty()) return success();
  const auto pins = read_pins(TeamSeal::known_robots_file(config.out));
  return pins ? success() : Status(pins.error());
}

Result<std::unique_ptr<TeamSeal>> TeamSeal::open(const Config& config, const comms::Identity& identity, Log& log) {
  const std::string file = team_key_file(config);
  if (file.empty()) return std::unique_ptr<TeamSeal>();
  const auto team = control::read_secret(file, control::kTeamKeyKind);
  if (!team) return team.error();
  std::unique_ptr<TeamSeal> seal(new TeamSeal(config.out, *team, identity));
  auto pins = read_pins(seal->known_robots_file());
  if (!pins) return pins.error();
  seal->pins_ = std::move(*pins);
  seal->pins_kept_ = seal->pins_.all().size();
  if (config.key_log.empty()) return seal;
  log.warn("the keys of all sessions are written to {}: whoever reads it can read this robot's traffic",
           config.key_log);
  if (auto opened = seal->open_key_log(config.key_log); !opened) return opened.error();
  return seal;
}

Status TeamSeal::open_key_log(const std::string& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0600);
  std::FILE* const opened = fd < 0 ? nullptr : ::fdopen(fd, "a");
  if (opened == nullptr) return Error{file, "the log of keys cannot be written"};
  key_log_ = {opened, std::fclose};
  return success();
}

void TeamSeal::keep_pins(Log& log) {
  if (pins_.all().size() == pins_kept_) return;
  std::string text;
  for (const auto& [robot, key] : pins_.all()) text += fmt::format("{} {}\n", robot.name(), hex(key));
  if (auto kept = write_text_file(known_robots_file(), text); !kept) {
    log.limited("known robots",
                "the keys of robots that were met cannot be kept: {}; make room or OUT writable, or whoever takes a "
                "robot's name after a restart is believed",
                kept.error().text());
    return;
  }
  pins_kept_ = pins_.all().size();
}

std::unique_ptr<comms::Guard> TeamSeal::guard(const comms::NodeConfig& config, comms::Node& node) {
  comms::GuardConfig guard{config.self, config.incarnation, config.group, team_, identity_, fill, {}, 64};
  if (key_log_)
    guard.key_log = [file = key_log_](std::string_view line) {
      std::fprintf(file.get(), "%.*s\n", static_cast<int>(line.size()), line.data());
      std::fflush(file.get());
    };
  return std::make_unique<comms::Guard>(std::move(guard), node, pins_);
}

std::string TeamSeal::words() const {
  return fmt::format("team key {}, this robot's key {}", comms::fingerprint(team_),
                     comms::fingerprint(identity_.public_key()));
}

}  // namespace onemap::daemon
