#include "daemon/config.hpp"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <charconv>
#include <functional>
#include <utility>

#include "hal/base/ids.hpp"

namespace onemap::daemon {

namespace {

// One key of the file: where it stands and how its value gets into the Config; an empty answer means accepted.
struct Key {
  const char* section;
  const char* name;
  std::function<std::string(const toml::node&, Config&)> set;
};

template <class T>
auto number(T min, T max, std::function<void(Config&, T)> store) {
  return [min, max, store = std::move(store)](const toml::node& node, Config& config) -> std::string {
    const auto value = node.value<T>();
    if (!value || node.is_boolean() || node.is_string()) return "expected a number";
    if (*value < min || *value > max) return fmt::format("{} is not within {}..{}", *value, min, max);
    store(config, *value);
    return {};
  };
}

auto text(std::function<std::string(Config&, const std::string&)> store) {
  return [store = std::move(store)](const toml::node& node, Config& config) -> std::string {
    const auto value = node.value_exact<std::string>();
    return value ? store(config, *value) : "expected a string";
  };
}

std::string set_peers(const toml::node& node, Config& config) {
  const toml::array* list = node.as_array();
  if (!list) return "expected a list of \"ADDR:PORT\"";
  config.peers.clear();
  for (const toml::node& item : *list) {
    const auto peer = item.value_exact<std::string>();
    if (!peer) return "expected a list of \"ADDR:PORT\"";
    config.peers.push_back(*peer);
  }
  return {};
}

std::string set_once(const toml::node& node, Config& config) {
  const auto value = node.value_exact<bool>();
  if (!value) return "expected true or false";
  config.once = *value;
  return {};
}

std::string set_features(Config& config, const std::string& value) {
  if (value == "surf")
    config.mapper.features = mapping::DescriptorKind::surf;
  else if (value == "orb")
    config.mapper.features = mapping::DescriptorKind::orb;
  else
    return "'" + value + "' is neither surf nor orb";
  return {};
}

std::string set_speed(const toml::node& node, Config& config) {
  const auto word = node.value_exact<std::string>();
  const auto factor = node.value<double>();
  const auto speed = parse_speed(word ? *word : factor && !node.is_boolean() ? fmt::format("{}", *factor) : "");
  if (!speed) return speed.error().reason;
  config.speed = *speed;
  return {};
}

auto plain(std::string Config::*member) {
  return text([member](Config& c, const std::string& v) { return c.*member = v, std::string(); });
}

const std::vector<Key>& keys() {
  using C = Config;
  using I = std::int64_t;
  static const std::vector<Key> table{
      {"robot", "id", plain(&C::id)},
      {"robot", "camera", plain(&C::camera)},
      {"robot", "out", plain(&C::out)},
      {"network", "listen", plain(&C::listen)},
      {"network", "peers", set_peers},
      {"network", "bytes_per_second",
       number<I>(10000, 1000000000, [](C& c, I v) { c.bytes_per_second = static_cast<std::uint64_t>(v); })},
      {"network", "store_budget_mb",
       number<I>(1, 65536, [](C& c, I v) { c.store_budget_bytes = static_cast<std::size_t>(v) << 20; })},
      {"run", "once", set_once},
      {"run", "speed", set_speed},
      {"run", "linger_s", number<double>(0, 1e6, [](C& c, double v) { c.linger_s = v; })},
      {"run", "lost_after_s", number<double>(1, 1e6, [](C& c, double v) { c.lost_after_s = v; })},
      {"run", "peer_wait_s", number<double>(0, 1e6, [](C& c, double v) { c.peer_wait_s = v; })},
      {"run", "merge_while_mapping_s", number<double>(0, 1e6, [](C& c, double v) { c.merge_while_mapping_s = v; })},
      {"run", "matches_picture", number<I>(0, 1000000, [](C& c, I v) { c.matches_picture = static_cast<int>(v); })},
      {"tracking", "features", text(set_features)},
      {"tracking", "max_features", number<I>(50, 1000, [](C& c, I v) { c.mapper.max_features = static_cast<int>(v); })},
      {"tracking", "max_keyframes",
       number<I>(2, 10000, [](C& c, I v) { c.mapper.max_keyframes = static_cast<int>(v); })},
      {"tracking", "keyframe_translation_m",
       number<double>(0.01, 5, [](C& c, double v) { c.mapper.keyframe_translation_m = v; })},
      {"tracking", "keyframe_rotation_deg",
       number<double>(0.5, 90, [](C& c, double v) { c.mapper.keyframe_rotation_deg = v; })},
      {"tracking", "min_motion_m", number<double>(0, 1, [](C& c, double v) { c.mapper.min_motion_m = v; })},
      {"tracking", "min_motion_deg", number<double>(0, 45, [](C& c, double v) { c.mapper.min_motion_deg = v; })},
      {"tracking", "seed", number<I>(0, INT64_MAX, [](C& c, I v) { c.mapper.seed = static_cast<std::uint64_t>(v); })},
      {"map", "voxel_m",
       number<double>(0.002, 0.5, [](C& c, double v) { c.mapper.map.voxel_m = static_cast<float>(v); })},
      {"map", "truncation_m",
       number<double>(0.004, 2, [](C& c, double v) { c.mapper.map.truncation_m = static_cast<float>(v); })},
      {"map", "max_depth_m",
       number<double>(0.5, 8, [](C& c, double v) { c.mapper.map.max_depth_m = static_cast<float>(v); })},
      {"map", "budget_mb",
       number<I>(1, 65536, [](C& c, I v) { c.mapper.map.budget_bytes = static_cast<std::size_t>(v) << 20; })},
      {"map", "global_budget_mb",
       number<I>(1, 65536, [](C& c, I v) { c.global_budget_bytes = static_cast<std::size_t>(v) << 20; })},
  };
  return table;
}

Error at(const std::string& file, const toml::source_region& where, std::string reason) {
  return {fmt::format("{}:{}", file, where.begin.line), std::move(reason)};
}

std::string known_in(std::string_view section) {
  std::string names;
  for (const Key& key : keys())
    if (section == key.section) names += (names.empty() ? "" : ", ") + std::string(key.name);
  return names;
}

Status set_section(const std::string& file, std::string_view section, const toml::table& table, Config& config) {
  for (const auto& [name, node] : table) {
    const Key* found = nullptr;
    for (const Key& key : keys())
      if (section == key.section && name.str() == key.name) found = &key;
    if (!found)
      return at(file, name.source(),
                fmt::format("unknown key '{}' in [{}]; known: {}", name.str(), section, known_in(section)));
    const std::string refused = found->set(node, config);
    if (!refused.empty()) return at(file, node.source(), fmt::format("{}.{}: {}", section, name.str(), refused));
  }
  return success();
}

Status set_all(const std::string& file, const toml::table& root, Config& config) {
  for (const auto& [section, node] : root) {
    const toml::table* table = node.as_table();
    if (!table || known_in(section.str()).empty())
      return at(file, section.source(),
                fmt::format("unknown {} '{}'; known sections: robot, network, run, tracking, map",
                            table ? "section" : "key", section.str()));
    if (auto status = set_section(file, section.str(), *table, config); !status) return status;
  }
  return success();
}

}  // namespace

Result<Speed> parse_speed(const std::string& text) {
  if (text == "max") return Speed{true, 1};
  double factor = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
  if (error != std::errc() || end != text.data() + text.size() || !(factor >= 0.01) || factor > 1000)
    return Error{"speed '" + text + "'", "expected max or a factor within 0.01..1000"};
  return Speed{false, factor};
}

Status load_config(const std::string& file, Config& config) {
  try {
    return set_all(file, toml::parse_file(file), config);
  } catch (const toml::parse_error& error) {
    return at(file, error.source(), std::string(error.description()));
  }
}

Status check_config(const Config& config) {
  if (config.camera.empty()) return Error{"camera", "no camera given; say --camera ADDRESS or [robot] camera"};
  if (config.out.empty()) return Error{"out", "no folder given to write to; say --out OUT or [robot] out"};
  if (!RobotId::valid_name(config.id))
    return Error{"id '" + config.id + "'", "expected 1 to 16 characters of A-Z a-z 0-9 _ . -, not starting with '.'"};
  if (config.mapper.map.truncation_m < 2 * config.mapper.map.voxel_m)
    return Error{"map.truncation_m", "must be at least twice map.voxel_m"};
  return success();
}

}  // namespace onemap::daemon
