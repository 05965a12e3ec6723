#pragma once
#include <string>

#include "control/protocol.hpp"
#include "hal/base/result.hpp"

// `onemapctl team`: the key that all robots of a team have. Works on files of this machine; no daemon is asked.
namespace onemap::control {

struct TeamOptions {
  std::string file;     // empty: /etc/onemap/team.key
  std::string key;      // of join; empty: a line of standard input
  bool secret = false;  // of show: the key itself
  bool force = false;   // of init and join: in place of another key
};

// The same for people and for programs: class TEAM, file, fingerprint, and the key if it is asked for.
struct TeamSaid {
  std::string words;
  Json json;
};

// The error says what was wrong and what to do.
Result<TeamSaid> team_init(const TeamOptions& options);
Result<TeamSaid> team_show(const TeamOptions& options);
Result<TeamSaid> team_join(const TeamOptions& options, const std::string& line);

}  // namespace onemap::control
