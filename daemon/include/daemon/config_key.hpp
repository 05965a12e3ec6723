#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "daemon/config.hpp"

namespace onemap::daemon {

// What a file or a command line says for a key.
using ConfigValue = std::variant<bool, std::int64_t, double, std::string, std::vector<std::string>>;

// What a changed value of a key asks for when the file is read again (SIGHUP). `live` is for what only the main thread
// reads, each time anew: nothing else may change under a running daemon.
enum class Reload { restart, live };

// One key of the configuration: what people read about it, and how it gets into a Config and out of it again. The one
// table of these keys reads the file and the command line, and writes --help-config and parts of --help.
struct ConfigKey {
  std::string_view section, name;
  std::string text;                                        // one line; says the unit where there is one
  std::string values;                                      // what is accepted
  std::function<Status(const ConfigValue&, Config&)> set;  // its error has a reason only
  std::function<ConfigValue(const Config&)> get;
  Reload reload = Reload::restart;

  std::string full_name() const { return std::string(section) + "." + std::string(name); }
};

struct ConfigSection {
  std::string_view name, text;
};

std::span<const ConfigSection> config_sections();
std::span<const ConfigKey> config_keys();  // sections together, in their order
const ConfigKey* find_key(std::string_view section, std::string_view name);

// Why there is no such key or section: the nearest that there is, and all of them.
std::string unknown_key(std::string_view section, std::string_view name);
std::string unknown_section(std::string_view name);

// "; did you mean "X"?", if one of these words is near enough for a slip of the pen; else nothing.
std::string near_word(std::string_view word, std::span<const std::string_view> words);

// A value as TOML has it.
std::string toml_text(const ConfigValue& value);

// A file that read_config() reads: every key with its text and the value that `config` has.
std::string config_text(const Config& config);
// The values that `config` has, in a form that read_config() reads, and where each is from.
std::string origins_text(const Config& config);

}  // namespace onemap::daemon
