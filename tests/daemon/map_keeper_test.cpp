#include "daemon/map_keeper.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <semaphore>
#include <thread>

#include "daemon/clock.hpp"
#include "support/running.hpp"
#include "support/text_of.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using Saved = MapKeeper::Saved;

class MapKeeperTest : public testing::Test {
 protected:
  const test::TempFolder folder_;
  KeptMap map_{folder_.path().string()};
  Failures failures_;
  Log log_{"robot"};
};

TEST_F(MapKeeperTest, KeepsWhatTheTeamHasWhenItIsSettled) {
  std::atomic<int> asked = 0;
  const auto take = [&](const auto&) -> std::optional<Saved> {
    ++asked;
    return Saved{0xabc, {1, 2, 3}, {}};
  };
  MapKeeper keeper(map_, take, failures_, log_);
  keeper.start();
  keeper.tick(0xabc, false, now());
  keeper.tick(0, true, now());
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(asked, 0) << "not settled, or no map";
  const std::string file = folder_ / "map-0000000000000abc.omap";
  for (int i = 0; i < 1000 && !std::filesystem::exists(folder_ / "settled-map"); ++i) {
    keeper.tick(0xabc, true, now());
    std::this_thread::sleep_for(10ms);
  }
  for (int i = 0; i < 5; ++i) keeper.tick(0xabc, true, now());
  keeper.stop();
  EXPECT_EQ(asked, 1) << "it is kept already";
  EXPECT_EQ(test::text_of(file), "\1\2\3");
  EXPECT_EQ(map_.kept()->digest, 0xabcu);
}

// What is made of a map: once it is kept, for each that is, and its failure is the next one's chance.
TEST_F(MapKeeperTest, WhatFollowsAMapIsMadeOfEachThatIsKept) {
  std::counting_semaphore<8> made{0};
  std::atomic<std::uint64_t> digest = 1;
  const auto take = [&](const auto&) -> std::optional<Saved> {
    const std::uint64_t taken = digest;
    const auto then = [&, taken](const auto& stop) -> Status {
      EXPECT_FALSE(stop());
      EXPECT_THAT(test::text_of(folder_ / "settled-map"), testing::HasSubstr(fmt::format("{:016x}", taken)));
      made.release();
      if (taken == 1) return Error{"map.pgm", "no room"};
      return success();
    };
    return Saved{taken, {1}, then};
  };
  testing::internal::CaptureStderr();
  {
    MapKeeper keeper(map_, take, failures_, log_);
    keeper.start();
    keeper.tick(1, true, now());
    ASSERT_TRUE(made.try_acquire_for(test::kPatience * 20s));
    digest = 2;
    EXPECT_TRUE(test::wait_until(
        [&] {
          keeper.tick(2, true, now() + 1min);
          return made.try_acquire();
        },
        20s));
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(testing::HasSubstr("map.pgm and map.yaml stay as they were: map.pgm: no room; make room"),
                             testing::HasSubstr("map.refresh_plan")));
  EXPECT_FALSE(failures_.any());
}

// A team that is on its way from one map to the next most of the time is asked until it has one.
TEST_F(MapKeeperTest, AMapThatIsNotThereNowIsAskedForAgainAtOnce) {
  std::atomic<int> asked = 0;
  const auto take = [&](const auto&) -> std::optional<Saved> {
    if (++asked < 4) return std::nullopt;
    return Saved{1, {1}, {}};
  };
  MapKeeper keeper(map_, take, failures_, log_);
  keeper.start();
  const Instant same = now();
  EXPECT_TRUE(test::wait_until(
      [&] {
        keeper.tick(1, true, same);
        return std::filesystem::exists(folder_ / "settled-map");
      },
      20s));
  keeper.stop();
  EXPECT_EQ(asked, 4);
}

TEST_F(MapKeeperTest, NobodyWaitsForItButItsEnd) {
  std::binary_semaphore entered{0};
  const auto take = [&](const auto& stop) -> std::optional<Saved> {
    entered.release();
    while (!stop()) std::this_thread::sleep_for(1ms);
    return std::nullopt;
  };
  MapKeeper keeper(map_, take, failures_, log_);
  keeper.start();
  keeper.tick(1, true, now());
  entered.acquire();
  for (int i = 0; i < 1000; ++i) keeper.tick(2, true, now());  // comes back though it is busy
  keeper.stop();
  EXPECT_FALSE(map_.kept());
}

TEST_F(MapKeeperTest, WhatThrowsOrCannotBeWrittenIsSaidAndTheThreadGoesOn) {
  KeptMap nowhere("/nonexistent/place");
  std::counting_semaphore<8> asked{0};
  std::atomic<bool> throws = true;
  const auto take = [&](const auto&) -> std::optional<Saved> {
    asked.release();
    if (throws) throw std::bad_alloc();
    return Saved{1, {1}, {}};
  };
  testing::internal::CaptureStderr();
  {
    MapKeeper keeper(nowhere, take, failures_, log_);
    keeper.start();
    keeper.tick(1, true, now());
    asked.acquire();
    throws = false;
    while (!asked.try_acquire()) {
      keeper.tick(1, true, now() + 1min);
      std::this_thread::sleep_for(1ms);
    }
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(testing::HasSubstr("the settled map is not kept: settled map: out of memory"),
                             testing::HasSubstr("make room")));
  EXPECT_FALSE(failures_.any());
  EXPECT_FALSE(nowhere.kept());
}

}  // namespace
}  // namespace onemap::daemon
