#include "daemon/map_preset.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config_key.hpp"
#include "daemon/memory_limit.hpp"
#include "daemon/options.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(MapPreset, TheUsualOneChangesNothing) {
  Config config;
  const std::string before = config_text(config);
  apply_preset(config);
  EXPECT_EQ(config_text(config), before);
  EXPECT_TRUE(config.origins.empty());
}

TEST(MapPreset, FineIsACentimetreWithABandAndRoomForIt) {
  Config config;
  config.preset = MapPreset::fine;
  apply_preset(config);
  EXPECT_EQ(config.mapper.map.voxel_um(), 10'000);
  EXPECT_EQ(config.mapper.map.truncation_um(), 60'000);
  EXPECT_GT(config.mapper.map.budget_bytes, 5 * Config().mapper.map.budget_bytes);
  EXPECT_GE(config.global_budget_bytes, 3 * Config().global_budget_bytes);
  EXPECT_EQ(config.origins.at("map.voxel_m"), "map.preset");
  EXPECT_TRUE(check_memory(config, {std::uint64_t{1536} << 20, "the service's MemoryMax is"}).ok());
  EXPECT_THAT(find_key("map", "preset")->text, HasSubstr("voxel_m 0.01, truncation_m 0.06, budget_mb 256"));
}

// In whatever order they are said; and a file that says every key is one to say a preset in.
TEST(MapPreset, WhatIsSaidOtherwiseHolds) {
  const test::TempFolder folder;
  folder.write("c.toml", "[map]\nbudget_mb = 99\npreset = \"fine\"\nvoxel_m = 0.015\n");
  const auto parsed = parse_daemon_options({"--config", folder / "c.toml", "--camera", "replay:x", "--out", "o"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->mapper.map.voxel_um(), 15'000);
  EXPECT_EQ(parsed.value->mapper.map.budget_bytes, 99u << 20);
  EXPECT_EQ(parsed.value->origins.at("map.voxel_m"), folder / "c.toml:4");
  EXPECT_EQ(parsed.value->origins.at("map.global_budget_mb"), "map.preset");

  folder.write("every.toml", config_text({}));
  const auto every = parse_daemon_options(
      {"--config", folder / "every.toml", "--camera", "replay:x", "--out", "o", "--map-preset", "fine"});
  ASSERT_TRUE(every.value) << every.text;
  EXPECT_EQ(every.value->mapper.map.voxel_um(), 10'000);
}

TEST(MapPreset, WhatIsPrintedCanBeReadAgain) {
  const test::TempFolder folder;
  const auto dump = parse_daemon_options(
      {"--config", "/dev/null", "--camera", "replay:x", "--out", "o", "--map-preset", "fine", "--dump-config"});
  EXPECT_THAT(dump.text, AllOf(HasSubstr("preset = \"fine\"  # from command line\n"),
                               HasSubstr("voxel_m = 0.01  # from map.preset\n")));
  folder.write("c.toml", dump.text);
  const auto again = parse_daemon_options({"--config", folder / "c.toml"});
  ASSERT_TRUE(again.value) << again.text;
  EXPECT_EQ(again.value->mapper.map.voxel_um(), 10'000);
  EXPECT_EQ(again.value->mapper.map.truncation_um(), 60'000);
}

}  // namespace
}  // namespace onemap::daemon
