#include "daemon/config.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <climits>
#include <optional>

#include "daemon/addresses.hpp"
#include "daemon/config_key.hpp"
#include "daemon/memory_limit.hpp"
#include "daemon/team_seal.hpp"
#include "hal/base/file.hpp"
#include "hal/base/ids.hpp"

namespace onemap::daemon {

namespace {

Error at(const std::string& file, const toml::source_region& where, std::string reason) {
  return {fmt::format("{}:{}", file, where.begin.line), std::move(reason)};
}

std::optional<std::vector<std::string>> strings(const toml::array& array) {
  std::vector<std::string> list;
  for (const toml::node& item : array) {
    const auto text = item.value_exact<std::string>();
    if (!text) return std::nullopt;
    list.push_back(*text);
  }
  return list;
}

// Nothing: TOML has kinds of values that no key takes.
std::optional<ConfigValue> value_of(const toml::node& node) {
  if (const auto value = node.value_exact<bool>()) return *value;
  if (const auto value = node.value_exact<std::int64_t>()) return *value;
  if (const auto value = node.value_exact<double>()) return *value;
  if (const auto value = node.value_exact<std::string>()) return *value;
  if (const toml::array* array = node.as_array())
    if (auto list = strings(*array)) return std::move(*list);
  return std::nullopt;
}

using Errors = std::vector<Error>;

void set_key(const std::string& file, std::string_view section, const toml::key& name, const toml::node& node,
             Config& config, Errors& errors) {
  const ConfigKey* key = find_key(section, name.str());
  if (!key) return errors.push_back(at(file, name.source(), unknown_key(section, name.str())));
  const auto value = value_of(node);
  const Status set = value ? key->set(*value, config) : Error{"", "expected " + key->values};
  if (!set) return errors.push_back(at(file, node.source(), key->full_name() + ": " + set.error().reason));
  config.origins[key->full_name()] = at(file, node.source(), "").place;
}

void set_section(const std::string& file, const toml::key& name, const toml::node& node, Config& config,
                 Errors& errors) {
  const auto sections = config_sections();
  if (std::none_of(sections.begin(), sections.end(), [&](const ConfigSection& s) { return s.name == name.str(); }))
    return errors.push_back(at(file, name.source(), unknown_section(name.str())));
  const toml::table* table = node.as_table();
  if (!table)
    return errors.push_back(at(file, name.source(), fmt::format("'{0}' is a section: expected [{0}]", name.str())));
  for (const auto& [key, value] : *table) set_key(file, name.str(), key, value, config, errors);
}

// A key's name for what the mapper calls it.
std::string key_of(const std::string& place) {
  if (place == "map.budget_bytes") return "map.budget_mb";
  return place.find('.') == std::string::npos ? "tracking." + place : place;
}

// What keys ask of each other. The error's place is a key.
Status check_mapper(const Config& config) {
  // The camera is not known yet: the smallest that a mapper accepts.
  hal::Intrinsics camera;
  camera.width = camera.height = mapping::LocalMapperLimits::image_side_px.least;
  camera.fx = camera.fy = camera.width;
  camera.cx = camera.cy = camera.width / 2.0;
  return check_camera(config, camera);
}

// Where the value is from, instead of the key alone.
Status located(const Status& status, const Config& config) {
  if (status) return status;
  const auto origin = config.origins.find(status.error().place);
  return origin == config.origins.end() ? status : Error{origin->second, status.error().text()};
}

Status check_all(const Config& config) {
  if (config.camera.empty()) return Error{"camera", "no camera given; say --camera ADDRESS or [robot] camera"};
  if (config.out.empty()) return Error{"out", "no folder given to write to; say --out OUT or [robot] out"};
  if (!RobotId::valid_name(config.id))
    return Error{"id '" + config.id + "'", "expected 1 to 16 characters of A-Z a-z 0-9 _ . -, not starting with '.'"};
  if (auto status = check_mapper(config); !status) return status;
  if (auto status = check_addresses(config.listen, config.peers, config.group, own_network()); !status) return status;
  if (team_key_file(config).empty())
    if (auto status = check_reach_without_key(config); !status) return status;
  if (auto status = check_keys(config); !status) return status;
  return check_memory(config, memory_limit());
}

}  // namespace

Result<Speed> parse_speed(const std::string& text) {
  if (text == "max") return Speed{true, 1};
  double factor = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
  if (error != std::errc() || end != text.data() + text.size() || !(factor >= 0.01) || factor > 1000)
    return Error{"speed '" + text + "'", "expected max or a factor from 0.01 to 1000"};
  return Speed{false, factor};
}

Errors read_config(const std::string& file, Config& config) {
  const auto text = read_text_file(file);
  if (!text) return {text.error()};
  Errors errors;
  try {
    for (const auto& [section, node] : toml::parse(*text)) set_section(file, section, node, config, errors);
  } catch (const toml::parse_error& error) {
    errors.push_back(at(file, error.source(), std::string(error.description())));
  }
  return errors;
}

std::string id_from_host(const std::string& host) {
  std::string id = host.substr(0, 16);
  for (char& c : id)
    if (!RobotId::valid_name(std::string(1, c)) && c != '.') c = '-';
  if (id.starts_with('.')) id[0] = '-';
  return id.empty() ? "robot" : id;
}

std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

Status check_camera(const Config& config, const hal::Intrinsics& camera) {
  const Status fits = mapping::check(config.mapper, camera);
  return fits ? success() : Error{key_of(fits.error().place), fits.error().reason};
}

Status check_config(const Config& config) { return located(check_all(config), config); }

}  // namespace onemap::daemon
