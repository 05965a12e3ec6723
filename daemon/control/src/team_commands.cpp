#include "control/team_commands.hpp"

#include <fmt/format.h>

#include "comms/fingerprint.hpp"
#include "control/key_file.hpp"

namespace onemap::control {

namespace {
std::string file_of(const TeamOptions& options) {
  return options.file.empty() ? std::string(kTeamKeyFile) : options.file;
}

Json json_of(const std::string& file, const comms::TeamKey& key) {
  return {{"class", "TEAM"}, {"file", file}, {"fingerprint", comms::fingerprint(key)}};
}

Result<TeamSaid> install(const TeamOptions& options, const comms::TeamKey& key, const std::string& what,
                         const std::string& next) {
  const std::string file = file_of(options);
  if (auto written = write_secret(file, kTeamKeyKind, key, options.force ? Replace::yes : Replace::no); !written) {
    const Error& error = written.error();
    const bool there = error.reason.find("is there already") != std::string::npos;
    return there
               ? Error{error.place, error.reason + ": `onemapctl team show` says which key it is, --force replaces it"}
               : error;
  }
  return TeamSaid{fmt::format("{} {}\nfingerprint {}\n{}", what, file, comms::fingerprint(key), next),
                  json_of(file, key)};
}
}  // namespace

Result<TeamSaid> team_init(const TeamOptions& options) {
  const auto key = new_secret();
  if (!key) return key.error();
  return install(options, *key, "made a key for a new team:",
                 fmt::format("every other robot of the team needs it, for example:\n"
                             "  onemapctl team show --secret --file {} | ssh ROBOT onemapctl team join\n"
                             "a running daemon takes it after a restart\n",
                             file_of(options)));
}

Result<TeamSaid> team_show(const TeamOptions& options) {
  const std::string file = file_of(options);
  const auto key = read_secret(file, kTeamKeyKind);
  if (!key) return key.error();
  TeamSaid said{fmt::format("{}\nfingerprint {}\n", file, comms::fingerprint(*key)), json_of(file, *key)};
  if (!options.secret) return said;
  said.json["key"] = secret_line(kTeamKeyKind, *key);
  said.words = secret_line(kTeamKeyKind, *key) + "\n";
  return said;
}

Result<TeamSaid> team_join(const TeamOptions& options, const std::string& line) {
  const auto key = parse_secret(line, kTeamKeyKind);
  if (!key) return Error{"the key", key.error().reason + "; `onemapctl team show --secret` prints it"};
  return install(options, *key, "joined:",
                 "the fingerprint is the same on all robots of the team; a running daemon takes it after a restart\n");
}

}  // namespace onemap::control
