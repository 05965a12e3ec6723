#include "team_table.hpp"

#include <gtest/gtest.h>

#include "sim_net.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;
using Merge = TeamTable::Merge;

const RobotId kSelf = RobotId::from_name("self"), kNeighbour = RobotId::from_name("other");
const Instant kHeard{10s};

TEST(TeamTable, OnlyWhoWroteOrIsANeighbourCounts) {
  TeamTable team(kSelf, 7, 100, 32);
  EXPECT_EQ(team.merge({kNeighbour, 5, 1, 0, 0, 0}, kHeard), Merge::unknown);
  EXPECT_EQ(team.robots().size(), 1u);
  team.recorded({kNeighbour, 0, 5}, true, kHeard);
  EXPECT_EQ(team.robots().at(kNeighbour).counter, 0u) << "it has said nothing yet";
  EXPECT_EQ(team.merge({kNeighbour, 5, 1, 11, 12, 1}, kHeard + 1s), Merge::newer);
  EXPECT_EQ(team.last_sign(kNeighbour), kHeard + 1s);
  EXPECT_EQ(team.merge({kNeighbour, 6, 1, 0, 0, 0}, kHeard), Merge::unknown) << "no record of that life";
  EXPECT_EQ(team.merge({kNeighbour, 4, 9, 0, 0, 0}, kHeard), Merge::known) << "an older life";
  team.recorded({kNeighbour, 1, 6}, true, kHeard);
  EXPECT_EQ(team.robots().at(kNeighbour).flags, 0) << "a new life has said nothing";
  EXPECT_EQ(team.life_in_records(kNeighbour), 6u);
  EXPECT_EQ(team.logs_of(kNeighbour), 2u);
  team.left(kNeighbour);
  EXPECT_EQ(team.robots().size(), 2u) << "its records stay";
}

TEST(TeamTable, ANeighbourWithoutRecordsCountsWhileItIsThere) {
  TeamTable team(kSelf, 7, 100, 32);
  team.met(kNeighbour, 5, kHeard);
  EXPECT_EQ(team.robots().size(), 2u);
  team.left(kNeighbour);
  EXPECT_EQ(team.robots().size(), 1u);
}

TEST(TeamTable, CountersGoRound) {
  TeamTable team(kSelf, 7, 100, 32);
  team.met(kNeighbour, 5, kHeard);
  EXPECT_EQ(team.merge({kNeighbour, 5, 0x7FFFFFFF, 0, 0, 0}, kHeard), Merge::newer);
  EXPECT_EQ(team.merge({kNeighbour, 5, 0xFFFFFFF0, 0, 0, 0}, kHeard), Merge::newer);
  EXPECT_EQ(team.merge({kNeighbour, 5, 3, 0, 0, 0}, kHeard), Merge::newer);
  EXPECT_EQ(team.merge({kNeighbour, 5, 0xFFFFFFF1, 0, 0, 0}, kHeard), Merge::older);
}

// Who puts a greater counter into our mouth silences us only until we hear of it.
TEST(TeamTable, OwnCounterLeapsOverWhatOthersHeard) {
  TeamTable team(kSelf, 7, 100, 32);
  const auto said = team.say_own().counter;
  EXPECT_EQ(team.say_own().counter, said) << "nothing new";
  EXPECT_EQ(team.merge({kSelf, 7, 0xFFFFFF, 1, 1, 1}, kHeard), Merge::about_self);
  EXPECT_EQ(team.say_own().counter, 0x1000000u);
  EXPECT_EQ(team.own().flags, 0) << "its words are not ours";
  EXPECT_EQ(team.merge({kSelf, 7, 0xFFFFFF, 1, 1, 1}, kHeard), Merge::older);
  EXPECT_EQ(team.merge({kSelf, 8, 1, 1, 1, 1}, kHeard), Merge::later_self);
}

TEST(TeamTable, IsBoundedAndKeepsPlacesForNeighbours) {
  TeamTable team(kSelf, 7, 20, 32);
  std::size_t robots = 0;
  while (team.room_for(sim::numbered("r", robots), false)) {
    team.recorded({sim::numbered("r", robots), 0, 1}, true, kHeard);
    ++robots;
  }
  EXPECT_EQ(robots, 14u) << "a quarter is for neighbours, one is ourselves";
  for (std::size_t k = 0; k < 30; ++k) team.met(sim::numbered("n", k), 1, kHeard);
  EXPECT_EQ(team.robots().size(), 20u);
  EXPECT_TRUE(team.room_for(sim::numbered("r", 0), false)) << "who is known stays welcome";
}

TEST(TeamTable, WhoWasKnownBeforeTheStartShowsItsSignThen) {
  TeamTable team(kSelf, 7, 20, 32);
  team.recorded({kNeighbour, 0, 5}, true, Instant{});
  team.start(kHeard);
  EXPECT_EQ(team.last_sign(kNeighbour), kHeard);
}

}  // namespace
}  // namespace onemap::comms
