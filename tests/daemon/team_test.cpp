// The team's thread: what is handed to it from other threads reaches the map, and what the map wants goes out.
#include "daemon/team.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

#include "daemon/clock.hpp"
#include "support/team_author.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using test::Author;

template <class Condition>
bool wait_until(Condition condition) {
  const Instant end = now() + 20s;
  while (!condition() && now() < end) std::this_thread::sleep_for(2ms);
  return condition();
}

struct TeamThread : testing::Test {
  Author self = test::small_robot("a"), other = test::small_robot("b");
  Log log{"a"};
  Failures failures;
  std::mutex mutex;
  std::vector<OutgoingRecord> published;
  TeamMapConfig config;

  std::unique_ptr<Team> begin() {
    config.atlas.map.budget_bytes = 4u << 20;
    auto team = std::make_unique<Team>(
        self.id(), self.incarnation(), config,
        [this](OutgoingRecord record) {
          const std::lock_guard lock(mutex);
          published.push_back(std::move(record));
        },
        failures, log);
    team->start();
    return team;
  }
  static void hand(Team& team, const Author& author) {
    for (const auto& record : author.written()) team.apply(record);
  }
  // Puts what was published into this robot's log.
  bool append(Team& team) {
    std::vector<OutgoingRecord> records;
    {
      const std::lock_guard lock(mutex);
      records.swap(published);
    }
    for (const OutgoingRecord& record : records)
      team.apply(self.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body));
    return !records.empty();
  }
};

TEST_F(TeamThread, TakesSoManyBytesAtATime) {
  Team idle(
      self.id(), self.incarnation(), config, [](OutgoingRecord) {}, failures, log);  // not started
  std::size_t taken = 0;
  for (; idle.has_room() && taken < 100; ++taken) {
    Record large{{{other.id(), 3, 1}, static_cast<std::uint32_t>(taken)}, 4, std::vector<std::uint8_t>(1u << 20)};
    idle.apply(std::make_shared<const Record>(std::move(large)));
  }
  EXPECT_EQ(taken, Team::kInboxBytes >> 20);
}

TEST_F(TeamThread, WorksOnWhatItIsGivenUntilTheMapIsSettled) {
  self.finish();
  other.finish();
  const auto team = begin();
  hand(*team, self);
  hand(*team, other);
  EXPECT_TRUE(wait_until([&] { return append(*team), team->view().settled; }));
  EXPECT_EQ(team->view().robots_known, 2u);
  team->stop();
  EXPECT_NE(team->map().solution(), nullptr);
  EXPECT_FALSE(failures.any());
}

TEST_F(TeamThread, HearsWhoIsThereAndWhoIsNot) {
  config.lost_after = 1h;
  self.finish();
  const auto team = begin();
  hand(*team, self);
  hand(*team, other);
  team->presence({{other.id(), now() - 2h}, {self.id(), now()}}, {});
  EXPECT_TRUE(wait_until([&] { return team->view().waiting.size() == 1; })) << "its records came just now";
  EXPECT_EQ(team->view().waiting[0].robot, other.id());
  EXPECT_EQ(team->view().waiting[0].what, Waiting::What::end);
}

TEST_F(TeamThread, UnderAnotherNumberTheOwnRecordsComeAgain) {
  const auto team = begin();
  hand(*team, self);
  EXPECT_TRUE(wait_until([&] { return team->view().robots_known == 1; }));
  team->begin_life(8, true);
  EXPECT_TRUE(wait_until([&] { return team->view().robots_known == 0; }));
  hand(*team, test::small_robot("a", 1));
  hand(*team, test::small_robot("a", 8));
  EXPECT_TRUE(wait_until([&] { return team->view().robots_known == 1; }));
  team->stop();
  EXPECT_EQ(team->map().log().find(self.id())->incarnation, 8u);
}

// Who makes records as fast as it can waits for the thread that finds needless ones, and not for ever.
TEST_F(TeamThread, WhoMakesRecordsWaitsUntilTheyWereLookedAt) {
  config.merge_while_mapping = 1h;
  config.map_interval = 1ms;
  const auto team = begin();
  hand(*team, self);
  team->catch_up();  // nothing to wait for
  std::atomic<bool> held = false, go_on = false;
  team->ask([&](mapping::TeamMap&) {  // a map that takes long, while many records wait
    if (team->view().unthinned <= Team::kMostUnthinned) return false;
    held = true;
    while (!go_on) std::this_thread::sleep_for(1ms);
    return true;
  });
  EXPECT_TRUE(wait_until([&] {
    for (std::size_t i = 0; !held && i <= Team::kMostUnthinned; ++i) team->apply(self.submap());
    append(*team);
    return held.load();
  }));
  const Instant began = now();
  team->catch_up();
  EXPECT_GE(now() - began, 900ms) << "it waits, but never for long";
  go_on = true;
  EXPECT_TRUE(wait_until([&] { return append(*team), team->view().unthinned == 0; }));
}

// What came just before the end is of the map, too.
TEST_F(TeamThread, TakesWhatCameBeforeItWasStopped) {
  for (int round = 0; round < 20; ++round) {
    const auto team = begin();
    hand(*team, self);
    team->stop();
    EXPECT_EQ(team->view().robots_known, 1u);
    EXPECT_NE(team->map().log().find(self.id()), nullptr);
  }
}

}  // namespace
}  // namespace onemap::daemon
