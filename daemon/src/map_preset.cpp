#include "daemon/map_preset.hpp"

#include <fmt/format.h>

#include <utility>

#include "daemon/config_key.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kPreset = "map.preset";

// A band of six voxels: the noise of depth does not shrink with them, and a thinner one doubles surfaces. A surface
// then takes five times as many blocks as of 2 cm.
const std::vector<std::pair<std::string_view, ConfigValue>>& fine() {
  static const std::vector<std::pair<std::string_view, ConfigValue>> values{{"voxel_m", 0.01},
                                                                            {"truncation_m", 0.06},
                                                                            {"budget_mb", std::int64_t{256}},
                                                                            {"global_budget_mb", std::int64_t{384}}};
  return values;
}

}  // namespace

void apply_preset(Config& config) {
  if (config.preset != MapPreset::fine) return;
  const Config usual;
  for (const auto& [name, value] : fine()) {
    const ConfigKey& key = *find_key("map", name);
    if (key.get(config) != key.get(usual) || !key.set(value, config)) continue;
    config.origins[key.full_name()] = kPreset;
  }
}

std::string fine_values() {
  std::string text;
  for (const auto& [name, value] : fine())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, toml_text(value));
  return text;
}

}  // namespace onemap::daemon
