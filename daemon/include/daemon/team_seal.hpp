#pragma once
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "comms/guard.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"

namespace onemap::daemon {

// The file with the team's key, as the configuration and this machine say: team.key_file; else /etc/onemap/team.key if
// it is there; else OUT/team.key if it is there; empty: none.
std::string team_key_file(const Config& config);

// Without a key, what is not this machine's is refused; the error's place is a key of the configuration.
Status check_reach_without_key(const Config& config);

// Whether the keys can be used with which it would start: the team's, its own and those of the robots that it has met,
// as far as there are any yet. Trying again would mend none of them, so a start does not get as far as that.
Status check_keys(const Config& config);

// What a robot of a team with a key keeps in files beside its identity: the team's key, and the keys of the robots that
// it has met (OUT/known_robots: a line `NAME KEY` each).
class TeamSeal {
 public:
  // nullptr: this team has no key. The error says what is wrong with a file, and what to do.
  static Result<std::unique_ptr<TeamSeal>> open(const Config& config, const comms::Identity& identity, Log& log);
  std::unique_ptr<comms::Guard> guard(const comms::NodeConfig& config, comms::Node& node);
  void keep_pins(Log& log);   // writes those that are new; says when that fails
  std::string words() const;  // the team's and the robot's fingerprint
  static std::string known_robots_file(const std::string& out) { return out + "/known_robots"; }
  std::string known_robots_file() const { return known_robots_file(out_); }

 private:
  TeamSeal(std::string out, const comms::TeamKey& team, comms::Identity identity)
      : out_(std::move(out)), team_(team), identity_(std::move(identity)) {}
  Status open_key_log(const std::string& file);
  std::string out_;
  comms::TeamKey team_;
  comms::Identity identity_;
  comms::Pins pins_;
  std::size_t pins_kept_ = 0;
  std::shared_ptr<std::FILE> key_log_;
};

}  // namespace onemap::daemon
