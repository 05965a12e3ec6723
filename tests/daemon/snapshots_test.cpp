#include "daemon/snapshots.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/clock.hpp"
#include "support/running.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using test::TempFolder;
using testing::HasSubstr;
namespace fs = std::filesystem;

mapping::VoxelMap one_wall() {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 4u << 20;
  config.image_pixels = 0;
  mapping::VoxelMap map(config);
  for (std::size_t i = 0; i < mapping::kBlockVoxels; ++i) {
    mapping::Voxel& voxel = map.find_or_add({0, 0, 0})[i];
    voxel.add_tsdf(200 * (static_cast<int>(i % 8) - 3), 5);
    voxel.add_color(200, 100, 50);
  }
  return map;
}

std::optional<MapCopy> a_wall(const std::function<bool()>&) {
  const mapping::ChainId self{RobotId::from_name("robot"), 7};
  MapCopy copy{mapping::TeamLog(self.robot, self.incarnation), std::nullopt, std::nullopt, 3ms};
  copy.solution = mapping::alone_on_map(self);
  copy.map.emplace(one_wall());
  return copy;
}

struct Fixture : testing::Test {
  Fixture() {
    config.id = "robot";
    config.out = folder.path().string();
    config.listen = "127.0.0.1:0";
    config.snapshots.kinds = {"png", "glb"};
    config.snapshots.maps = {"global"};
  }
  bool finished(const Snapshots& snapshots, std::uint64_t number) {
    return test::wait_until([&] { return snapshots.view().finished >= number; }, 60s);
  }
  const TempFolder folder;
  Config config;
  Failures failures;
  Log log{"robot"};
};
using SnapshotsTest = Fixture;

TEST_F(SnapshotsTest, ARequestBecomesAFolderOfPicturesAndModels) {
  Snapshots snapshots(config, a_wall, failures, log);
  snapshots.start();
  ASSERT_TRUE(finished(snapshots, snapshots.request({{"top", "front"}, {"png", "glb"}, {"global"}})));
  const SnapshotsView view = snapshots.view();
  EXPECT_EQ(view.error, "");
  EXPECT_EQ(view.made, 1u);
  EXPECT_EQ(view.folder, folder / "snapshots/000001");
  EXPECT_DOUBLE_EQ(view.copy_ms, 3);
  for (const char* file : {"global_top.png", "global_front.png", "global.glb"})
    EXPECT_TRUE(fs::exists(folder / "snapshots/latest" + "/" + file)) << file;
  EXPECT_EQ(std::distance(fs::directory_iterator(view.folder), fs::directory_iterator()), 3) << "and nothing else";
}

TEST_F(SnapshotsTest, ARobotAloneHasOneMapItsLocalOne) {
  config.listen.clear();
  Snapshots snapshots(config, a_wall, failures, log);
  snapshots.start();
  ASSERT_TRUE(finished(snapshots, snapshots.request(default_wish(config.snapshots))));
  EXPECT_TRUE(fs::exists(snapshots.view().folder + "/local_fit.png")) << snapshots.view().error;
  EXPECT_TRUE(fs::exists(snapshots.view().folder + "/local.glb"));
}

TEST_F(SnapshotsTest, OneJobAtATimeAndTheNewestWaits) {
  std::mutex gate;
  gate.lock();
  Snapshots snapshots(
      config,
      [&](const std::function<bool()>& stop) {
        const std::lock_guard wait(gate);
        return a_wall(stop);
      },
      failures, log);
  snapshots.start();
  snapshots.request({{"top"}, {"png"}, {"global"}});
  ASSERT_TRUE(test::wait_until([&] { return snapshots.view().busy; }, 20s));
  for (const char* view : {"fit", "follow", "front"}) snapshots.request({{view}, {"png"}, {"global"}});
  EXPECT_EQ(snapshots.view().coalesced, 2u);
  gate.unlock();
  ASSERT_TRUE(finished(snapshots, 4));
  EXPECT_EQ(snapshots.view().made, 2u);
  EXPECT_TRUE(fs::exists(folder / "snapshots/000001/global_top.png"));
  EXPECT_TRUE(fs::exists(folder / "snapshots/000002/global_front.png"));
}

TEST_F(SnapshotsTest, WhatCannotBeDrawnIsSaidAndTheNextOneIsMade) {
  std::atomic<int> calls = 0;
  Snapshots snapshots(
      config,
      [&](const std::function<bool()>& stop) {
        auto copy = a_wall(stop);
        if (++calls == 1) copy->solution.reset(), copy->map.reset();
        if (calls == 2) throw std::runtime_error("no memory for it");
        return copy;
      },
      failures, log);
  snapshots.start();
  testing::internal::CaptureStderr();
  ASSERT_TRUE(finished(snapshots, snapshots.request(default_wish(config.snapshots))));
  EXPECT_THAT(snapshots.view().error, HasSubstr("nothing to draw yet"));
  ASSERT_TRUE(finished(snapshots, snapshots.request(default_wish(config.snapshots))));
  EXPECT_THAT(snapshots.view().error, HasSubstr("no memory for it"));
  ASSERT_TRUE(finished(snapshots, snapshots.request(default_wish(config.snapshots))));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("no snapshot: snapshot: there is nothing to draw yet"));
  EXPECT_EQ(snapshots.view().made, 1u);
  EXPECT_EQ(snapshots.view().failed, 2u);
  EXPECT_FALSE(fs::exists(folder / "snapshots/.partial"));
  EXPECT_FALSE(failures.any());
}

TEST_F(SnapshotsTest, ADrawingThatTakesTooMuchIsKilledAndCounted) {
  PictureLimits limits = Snapshots::snapshot_limits();
  limits.time = 1ms;
  Snapshots snapshots(config, a_wall, failures, log, limits);
  snapshots.start();
  ASSERT_TRUE(finished(snapshots, snapshots.request(default_wish(config.snapshots))));
  EXPECT_THAT(snapshots.view().error, HasSubstr("took too long"));
  EXPECT_EQ(snapshots.view().killed, 1u);
  EXPECT_FALSE(fs::exists(folder / "snapshots/000001"));
  EXPECT_FALSE(fs::exists(folder / "snapshots/.partial")) << "nothing of it stays";
}

TEST_F(SnapshotsTest, TimeAndChangeAskAsConfigured) {
  config.snapshots.every_s = 100;
  config.snapshots.on_change = true;
  Snapshots snapshots(
      config, [](auto&) -> std::optional<MapCopy> { return std::nullopt; }, failures, log);
  const auto asked = [&](Duration at, std::uint64_t digest) {
    const auto before = snapshots.view().coalesced;  // nobody works: each but the first takes one's place
    snapshots.tick(Instant(1h + at), digest);
    return snapshots.view().coalesced > before;
  };
  EXPECT_EQ(snapshots.request({}), 1u);
  EXPECT_FALSE(asked(0s, 0)) << "no map yet";
  EXPECT_TRUE(asked(1s, 5)) << "the first map";
  EXPECT_FALSE(asked(2s, 5));
  EXPECT_FALSE(asked(3s, 6)) << "so soon";
  EXPECT_TRUE(asked(12s, 6));
  EXPECT_FALSE(asked(99s, 6));
  EXPECT_TRUE(asked(100s, 6)) << "it is time";
  EXPECT_FALSE(asked(199s, 6));
  EXPECT_TRUE(asked(201s, 6));
}

TEST_F(SnapshotsTest, StoppingDoesNotWaitForADrawing) {
  std::atomic<bool> taking = false;
  Snapshots snapshots(
      config,
      [&](const std::function<bool()>& stop) -> std::optional<MapCopy> {
        taking = true;
        while (!stop()) usleep(1000);
        return std::nullopt;
      },
      failures, log);
  snapshots.start();
  snapshots.request(default_wish(config.snapshots));
  ASSERT_TRUE(test::wait_until([&] { return taking.load(); }, 20s));
  snapshots.stop();
  EXPECT_EQ(snapshots.view().made, 0u);
}

TEST(MapCopy, HasEveryBlockOfTheMap) {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 32u << 20;
  config.image_pixels = 0;
  mapping::VoxelMap map(config);
  for (int i = 0; i < 3000; ++i) {
    mapping::Voxel* voxels = map.find_or_add({i % 17, i / 17, -i});
    ASSERT_NE(voxels, nullptr);
    voxels[i % mapping::kBlockVoxels].add_tsdf(i % 1000, 3);
  }
  EXPECT_EQ(copy_of(map).digest(), map.digest());
}

}  // namespace
}  // namespace onemap::daemon
