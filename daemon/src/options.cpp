#include "daemon/options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <deque>

#include "daemon/cameras.hpp"
#include "daemon/command_line.hpp"
#include "daemon/config_key.hpp"

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
    {"--once", "run", "once", ""},
    {"--speed", "run", "speed", "X|max"},
    {"--features", "tracking", "features", "KIND"},
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
  bool help_config = false, cameras = false;
  std::deque<Given> options;  // CLI11 keeps pointers into it
};

std::string footer() {
  std::string text = "Cameras:\n";
  for (const hal::Backend& backend : camera_backends())
    text += fmt::format("  {:<10} {}\n", backend.name, backend.description);
  return text +
         "\nWithout --listen, --peer and a group (network.group) the robot is alone. A recording without --once is "
         "played\n"
         "to its end, and the daemon then keeps serving what it knows until SIGTERM or SIGINT, which write everything\n"
         "and end it.\n"
         "\nExit status:\n"
         "  0  done: frames processed, everything written, and with --once in a team: all finished with equal maps\n"
         "  1  something could not be done (the camera cannot be opened, the port is taken, OUT cannot be written to,\n"
         "     no frame could be placed, ...); the last lines on stderr say what and why\n"
         "  2  bad command line or configuration file, an address that cannot be right included; nothing was opened\n"
         "  3  --once, but stopped before the work was done, or without some of the team; what there was is written\n";
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
  line.config_given = app.add_option("--config", line.config, "TOML file; the command line goes over it");
  line.config_given->type_name("FILE");
  app.add_flag("--cameras", line.cameras, "list the cameras of this machine, and why one cannot be used");
  app.add_flag("--help-config", line.help_config, "print a commented configuration with every key, and exit");
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

Status apply(const CommandLine& line, Config& config) {
  for (const Given& given : line.options) {
    if (given.parsed->count() == 0) continue;
    const ConfigValue value = value_of(given);
    if (is_empty(value)) return Error{given.option->flag, "is given but empty"};
    if (auto set = given.key->set(value, config); !set) return Error{given.option->flag, set.error().reason};
  }
  return success();
}

Status read(const CommandLine& line, Config& config) {
  Status status = line.config_given->count() == 0 ? success() : load_config(line.config, config);
  if (status) status = apply(line, config);
  if (config.id.empty()) config.id = id_from_host(host_name());
  return status ? check_config(config) : status;
}

}  // namespace

Parsed<Config> parse_daemon_options(const std::vector<std::string>& arguments) {
  CLI::App app("onemapd - tracks an RGB-D camera, maps what it sees, and shares one map with its team", kProgram);
  CommandLine line;
  declare(app, line);
  if (auto ending = parse_command_line(app, arguments)) return {std::move(*ending), std::nullopt};
  if (line.help_config) return {{Exit::done, config_text({})}, std::nullopt};
  if (line.cameras) return {{Exit::done, cameras_text(hal::list_cameras(camera_backends()))}, std::nullopt};
  Config config;
  if (auto status = read(line, config); !status)
    return {{Exit::usage, complaint(kProgram, status.error().text())}, std::nullopt};
  return {{}, std::move(config)};
}

}  // namespace onemap::daemon
