#include "daemon/options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <deque>

#include "daemon/cameras.hpp"
#include "daemon/command_line.hpp"
#include "daemon/config_key.hpp"
#include "daemon/man.hpp"
#include "daemon/map_preset.hpp"
#include "daemon/team_seal.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kProgram = "onemapd";

// An option is a key of the configuration that can be said on the command line, too.
struct Option {
  const char *flag, *section, *key, *type;
};
constexpr Option kOptions[] = {
    {"--camera", "robot", "camera", "ADDRESS"},
    {"--id", "robot", "id", "NAME"},
    {"--listen", "network", "listen", "ADDR:PORT"},
    {"--peer", "network", "peers", "ADDR:PORT"},
    {"--team-key", "team", "key_file", "FILE"},
    {"--key-log", "team", "key_log", "FILE"},
    {"--once", "run", "once", ""},
    {"--quick-stop", "run", "quick_stop", ""},
    {"--speed", "run", "speed", "X|max"},
    {"--features", "tracking", "features", "KIND"},
    {"--map-preset", "map", "preset", "NAME"},
    {"--linger", "run", "linger_s", "S"},
    {"--matches-picture", "run", "matches_picture", "N"},
    {"--out", "robot", "out", "OUT"},
};

// What was given for an option, as it was given.
struct Given {
  const Option* option = nullptr;
  const ConfigKey* key = nullptr;
  CLI::Option* parsed = nullptr;
  std::string text;
  std::vector<std::string> list;
  bool flag = false;
};

struct CommandLine {
  std::string config;
  CLI::Option* config_given = nullptr;
  bool help_config = false, cameras = false, json = false, check = false, dump = false;
  std::string man;
  std::deque<Given> options;  // CLI11 keeps pointers into it
};

constexpr ManExit kExits[] = {
    {0, "done: frames processed, everything written, and with --once in a team: all finished with equal maps"},
    {1,
     "something could not be done (the camera cannot be opened, the port is taken, OUT cannot be written to,\n"
     "no frame could be placed, ...); the last lines on stderr say what and why"},
    {2,
     "bad command line or configuration file, an address that cannot be right or a key that cannot be used included;\n"
     "nothing was opened"},
    {3, "--once, but stopped before the work was done, or without some of the team; what there was is written"},
};

std::string exit_words() {
  std::string words;
  for (const ManExit& exit : kExits) {
    words += fmt::format("  {}  ", exit.status);
    for (const char c : exit.text) words += c == '\n' ? "\n     " : std::string(1, c);
    words += '\n';
  }
  return words;
}

std::string footer() {
  std::string text = "Cameras:\n";
  for (const hal::Backend& backend : camera_backends())
    text += fmt::format("  {:<10} {}\n", backend.name, backend.description);
  return text +
         fmt::format(
             "\nWithout --id the robot is named after the host, here {}. Without --listen, --peer and a group "
             "(network.group)\n"
             "it is alone, but for one with a team key and without --once, which meets its team in the group {}.\n",
             id_from_host(host_name()), kTeamGroup) +
         "\nWhat is not said here is in /etc/onemap/onemap.toml and /etc/onemap/onemap.toml.d/*.toml, or has its "
         "default.\n"
         "SIGHUP reads all of it again: what can change in a running daemon does, of the rest it says that it waits "
         "for a restart.\n"
         "A recording without --once is played to its end, and the daemon then keeps serving what it knows until "
         "SIGTERM or\n"
         "SIGINT, which write everything and end it.\n" +
         "\nExamples:\n"
         "  onemapd --camera replay:DIR --once --speed max --out OUT\n"
         "  onemapd --camera 'simulated:living-room?frames=300' --once --speed max --out OUT\n"
         "  onemapd --camera auto --id left --listen 0.0.0.0:4600 --peer 10.0.0.2:4600 --out OUT\n"
         "  onemapd --help-config > onemap.toml && onemapd --config onemap.toml --check-config\n"
         "\nExit status:\n" +
         exit_words();
}

void declare(CLI::App& app, Given& given) {
  const bool is_list = std::holds_alternative<std::vector<std::string>>(given.key->get({}));
  if (std::holds_alternative<bool>(given.key->get({}))) {
    given.parsed = app.add_flag(given.option->flag, given.flag, given.key->text);
  } else if (is_list) {
    given.parsed = app.add_option(given.option->flag, given.list, given.key->text + "; may be given several times");
    given.parsed->allow_extra_args(false);
  } else {
    given.parsed = app.add_option(given.option->flag, given.text, given.key->text);
  }
  if (*given.option->type) given.parsed->type_name(given.option->type);
}

void declare(CLI::App& app, CommandLine& line) {
  for (const Option& option : kOptions) {
    line.options.push_back({&option, find_key(option.section, option.key), nullptr, {}, {}, false});
    declare(app, line.options.back());
  }
  line.config_given = app.add_option(
      "--config", line.config,
      "TOML file instead of /etc/onemap/onemap.toml; FILE.d/*.toml and then the command line go over it");
  line.config_given->type_name("FILE");
  app.add_flag("--check-config", line.check, "read the configuration, say everything that is wrong with it, and exit");
  app.add_flag("--dump-config", line.dump, "print the values that hold, and where each is from, and exit");
  app.add_flag("--cameras", line.cameras,
               "list the cameras of this machine, what each can do, and why one cannot be used");
  app.add_flag("--json", line.json, "with --cameras: as one JSON object in a line");
  app.add_flag("--help-config", line.help_config, "print a commented configuration with every key, and exit");
  app.add_option("--man", line.man, "print a man page, for man -l: of this program (8) or of its configuration (5)")
      ->type_name("8|5")
      ->check(CLI::IsMember({"8", "5"}));
  app.footer(footer());
}

// What the words on a command line are for a key: a number where it has one, else text (of which a key that wants a
// number says that it is none).
ConfigValue value_of(const Given& given) {
  const ConfigValue known = given.key->get({});
  if (std::holds_alternative<bool>(known)) return given.flag;
  if (std::holds_alternative<std::vector<std::string>>(known)) return given.list;
  const char *begin = given.text.data(), *end = begin + given.text.size();
  if (std::holds_alternative<std::int64_t>(known)) {
    std::int64_t whole = 0;
    if (const auto [stop, code] = std::from_chars(begin, end, whole); code == std::errc{} && stop == end) return whole;
  }
  if (std::holds_alternative<double>(known)) {
    double real = 0;
    if (const auto [stop, code] = std::from_chars(begin, end, real); code == std::errc{} && stop == end) return real;
  }
  return given.text;
}

bool is_empty(const ConfigValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text && text->empty();
}

Status apply(const Given& given, Config& config) {
  const ConfigValue value = value_of(given);
  if (is_empty(value)) return Error{given.option->flag, "is given but empty"};
  if (auto set = given.key->set(value, config); !set) return Error{given.option->flag, set.error().reason};
  config.origins[given.key->full_name()] = "command line";
  return success();
}

void fill_in_out(const Surroundings& surroundings, Config& config) {
  if (!config.out.empty()) return;
  const DefaultOut out = default_out(surroundings);
  config.out = out.folder;
  if (!out.folder.empty()) config.origins["robot.out"] = "default, " + out.origin;
}

// A robot with a team's key looks for its team; one that only works through a recording (once) does not join by that.
void fill_in_group(Config& config) {
  if (!config.alone() || config.once || team_key_file(config).empty()) return;
  config.group = kTeamGroup;
  config.origins["network.group"] = "default, there is a team key";
}

void fill_in(const Surroundings& surroundings, Config& config) {
  if (config.id.empty()) {
    config.id = id_from_host(host_name());
    config.origins["robot.id"] = "default, the host's name";
  }
  fill_in_out(surroundings, config);
  fill_in_group(config);  // a key may be in OUT
}

// Everything that is wrong with what is read; what does not fit together is looked for in what is right by itself.
std::vector<Error> read(const CommandLine& line, const Surroundings& surroundings, Config& config) {
  const bool named = line.config_given->count() != 0;
  auto errors = read_config_files(named ? line.config : surroundings.config_file, named, config);
  for (const Given& given : line.options) {
    if (given.parsed->count() == 0) continue;
    if (auto status = apply(given, config); !status) errors.push_back(status.error());
  }
  apply_preset(config);
  fill_in(surroundings, config);
  if (!errors.empty() || line.dump) return errors;
  if (auto status = check_config(config); !status) errors.push_back(status.error());
  return errors;
}

Ending refused(const std::vector<Error>& errors) {
  std::string text;
  for (const Error& error : errors) text += complaint(kProgram, error.text());
  return {Exit::usage, text};
}

std::string man_page(const CLI::App& app, const std::string& page) {
  if (page == "5") return man_of_config();
  std::vector<ManOption> options;
  for (const CLI::Option* option : app.get_options())
    options.push_back({option->get_name(false, true), option->get_expected_max() > 0 ? option->get_type_name() : "",
                       option->get_description()});
  return man_of_daemon(options, kExits);
}

std::string list_of_cameras(bool json) {
  const auto cameras = hal::list_cameras(camera_backends());
  return json ? cameras_json_text(cameras) : cameras_text(cameras);
}

// What is said instead of working; nothing: go on with what was read.
std::optional<Ending> parse(const std::vector<std::string>& arguments, const Surroundings& surroundings, Config& config,
                            std::vector<Error>& errors) {
  CLI::App app("onemapd - tracks an RGB-D camera, maps what it sees, and shares one map with its team", kProgram);
  CommandLine line;
  declare(app, line);
  if (auto ending = parse_command_line(app, arguments)) return ending;
  if (line.help_config) return Ending{Exit::done, config_text({})};
  if (!line.man.empty()) return Ending{Exit::done, man_page(app, line.man)};
  if (line.cameras) return Ending{Exit::done, list_of_cameras(line.json)};
  if (line.json) return Ending{Exit::usage, complaint(kProgram, "--json goes with --cameras")};
  errors = read(line, surroundings, config);
  if (!errors.empty()) return refused(errors);
  if (line.dump) return Ending{Exit::done, origins_text(config)};
  if (line.check) return Ending{Exit::done, "the configuration is good\n"};
  return std::nullopt;
}

}  // namespace

Parsed<Config> parse_daemon_options(const std::vector<std::string>& arguments, const Surroundings& surroundings) {
  Config config;
  std::vector<Error> errors;
  if (auto ending = parse(arguments, surroundings, config, errors)) return {std::move(*ending), std::nullopt};
  return {{}, std::move(config)};
}

Result<Config> reload_config(const std::vector<std::string>& arguments, const Surroundings& surroundings) {
  Config config;
  std::vector<Error> errors;
  const auto ending = parse(arguments, surroundings, config, errors);
  if (!ending) return config;
  std::string reasons;
  for (const Error& error : errors) reasons += (reasons.empty() ? "" : "; ") + error.text();
  return Error{"the configuration is as it was", errors.empty() ? ending->text : reasons};
}

}  // namespace onemap::daemon
