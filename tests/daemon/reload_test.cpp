#include "daemon/reload.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/options.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Reload, WhatIsTheSameIsNoChange) {
  Config running, loaded;
  loaded.origins["run.linger_s"] = "elsewhere:1";
  const ReloadPlan plan = plan_reload(running, loaded);
  EXPECT_TRUE(plan.live.empty() && plan.restart.empty());
  EXPECT_EQ(to_text(plan), "nothing changed");
}

TEST(Reload, TellsWhatIsLiveFromWhatNeedsARestart) {
  Config running, loaded;
  loaded.linger_s = 5;
  loaded.mapper.map.voxel_m = 0.05f;
  loaded.peers = {"10.0.0.2:1"};
  loaded.origins["run.linger_s"] = "c.toml:4";
  const ReloadPlan plan = plan_reload(running, loaded);
  ASSERT_EQ(plan.live.size(), 1u);
  EXPECT_EQ(plan.live[0].key->full_name(), "run.linger_s");
  ASSERT_EQ(plan.restart.size(), 2u);
  EXPECT_EQ(to_text(plan),
            "run.linger_s is 5 now, was 3; only a restart changes network.peers ([\"10.0.0.2:1\"] after []), "
            "map.voxel_m (0.05 after 0.02)");
  apply_reload(plan, loaded, running);
  EXPECT_EQ(running.linger_s, 5);
  EXPECT_EQ(running.origins.at("run.linger_s"), "c.toml:4");
  EXPECT_EQ(running.mapper.map.voxel_m, Config().mapper.map.voxel_m);
  EXPECT_TRUE(running.peers.empty());
  EXPECT_TRUE(plan_reload(running, loaded).live.empty());
}

// Every key is either taken over whole or not at all.
TEST(Reload, EveryLiveKeyIsTakenOver) {
  Config running, loaded;
  loaded.quick_stop = true;
  loaded.linger_s = 1;
  loaded.peer_wait_s = 2;
  loaded.snapshots.every_s = 7;
  loaded.snapshots.on_change = true;
  loaded.snapshots.views = {"top"};
  loaded.snapshots.kinds = {"png"};
  loaded.snapshots.maps = {"local"};
  const ReloadPlan plan = plan_reload(running, loaded);
  apply_reload(plan, loaded, running);
  for (const ConfigKey& key : config_keys()) {
    if (key.reload == Reload::live) {
      EXPECT_NE(key.get(running), key.get(Config())) << key.full_name() << " is not tried here";
    }
    EXPECT_EQ(key.get(running), key.get(loaded)) << key.full_name();
  }
}

TEST(Reload, TheSameCommandLineReadsTheFilesAgain) {
  const test::TempFolder folder;
  const std::vector<std::string> arguments{"--config", folder / "c.toml", "--out", "o", "--linger", "7"};
  folder.write("c.toml", "[run]\nlinger_s = 1\npeer_wait_s = 1\n");
  const auto running = parse_daemon_options(arguments);
  ASSERT_TRUE(running.value) << running.text;
  folder.write("c.toml", "[run]\nlinger_s = 2\npeer_wait_s = 2\n");
  const auto loaded = reload_config(arguments);
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(to_text(plan_reload(*running.value, *loaded)), "run.peer_wait_s is 2 now, was 1");
  folder.write("c.toml", "[run]\nlinger_s = -2\nwait = 2\n");
  const auto bad = reload_config(arguments);
  ASSERT_FALSE(bad.ok());
  EXPECT_THAT(bad.error().text(),
              AllOf(HasSubstr("the configuration is as it was: "), HasSubstr("c.toml:2: run.linger_s"), HasSubstr("; "),
                    HasSubstr("c.toml:3: unknown key 'wait'")));
}

}  // namespace
}  // namespace onemap::daemon
