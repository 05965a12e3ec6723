#include "daemon/config.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <climits>
#include <map>
#include <optional>

#include "daemon/addresses.hpp"
#include "daemon/config_key.hpp"
#include "daemon/memory_limit.hpp"
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

// Where each key stands in the file.
using Lines = std::map<std::string, toml::source_region>;

Status set_section(const std::string& file, std::string_view section, const toml::table& table, Config& config,
                   Lines& lines) {
  for (const auto& [name, node] : table) {
    const ConfigKey* key = find_key(section, name.str());
    if (!key) return at(file, name.source(), unknown_key(section, name.str()));
    const auto value = value_of(node);
    const Status set = value ? key->set(*value, config) : Error{"", "expected " + key->values};
    if (!set) return at(file, node.source(), key->full_name() + ": " + set.error().reason);
    lines[key->full_name()] = node.source();
  }
  return success();
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

Status set_all(const std::string& file, const toml::table& root, Config& config) {
  Lines lines;
  for (const auto& [section, node] : root) {
    const toml::table* table = node.as_table();
    const auto sections = config_sections();
    const bool known = std::any_of(sections.begin(), sections.end(),
                                   [&, &name = section](const ConfigSection& s) { return s.name == name.str(); });
    if (!known) return at(file, section.source(), unknown_section(section.str()));
    if (!table) return at(file, section.source(), fmt::format("'{0}' is a section: expected [{0}]", section.str()));
    if (auto status = set_section(file, section.str(), *table, config, lines); !status) return status;
  }
  const Status fits = check_mapper(config);
  if (fits) return success();
  const auto line = lines.find(fits.error().place);
  return line == lines.end() ? Error{file, fits.error().text()} : at(file, line->second, fits.error().text());
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

Status load_config(const std::string& file, Config& config) {
  const auto text = read_text_file(file);
  if (!text) return text.error();
  try {
    return set_all(file, toml::parse(*text), config);
  } catch (const toml::parse_error& error) {
    return at(file, error.source(), std::string(error.description()));
  }
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

Status check_config(const Config& config) {
  if (config.camera.empty()) return Error{"camera", "no camera given; say --camera ADDRESS or [robot] camera"};
  if (config.out.empty()) return Error{"out", "no folder given to write to; say --out OUT or [robot] out"};
  if (!RobotId::valid_name(config.id))
    return Error{"id '" + config.id + "'", "expected 1 to 16 characters of A-Z a-z 0-9 _ . -, not starting with '.'"};
  if (auto status = check_mapper(config); !status) return status;
  if (auto status = check_addresses(config.listen, config.peers, config.group, own_network()); !status) return status;
  return check_memory(config, memory_limit());
}

}  // namespace onemap::daemon
