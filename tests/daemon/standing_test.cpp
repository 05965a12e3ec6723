#include "daemon/standing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using testing::HasSubstr;
using What = Waiting::What;

struct Parts {
  PipelineProgress progress;
  TeamView team;
  RadioView radio;
  Parts() {
    progress.finished = true;
    team.settled = true;
    team.digest = 0xABCD;
    radio.agrees = true;
    radio.agreed_digest = 0xABCD;
  }
  Standing standing() const { return daemon::standing(progress, team, radio); }
};

Waiting waiting_for(const char* robot, What what, int silent_s = 0) {
  return {RobotId::from_name(robot), what, std::chrono::seconds(silent_s)};
}

TEST(Standing, AgreedWhenTheOwnWorkIsDoneAndAllHoldTheMap) {
  const Standing s = Parts().standing();
  EXPECT_TRUE(s.agreed);
  EXPECT_FALSE(s.stuck);
  EXPECT_EQ(s.waiting, "");
}

TEST(Standing, NobodyAgreesBeforeTheOwnWorkIsDone) {
  Parts parts;
  parts.progress.finished = false;
  EXPECT_FALSE(parts.standing().agreed);
  EXPECT_EQ(parts.standing().waiting, "");
}

TEST(Standing, AMapThatIsNotSettledIsNoAgreement) {
  Parts parts;
  parts.team.settled = false;
  EXPECT_FALSE(parts.standing().agreed);
  EXPECT_EQ(parts.standing().waiting, "waiting for the map to be merged");
}

TEST(Standing, OthersMustSayTheVeryDigestOfTheOwnMap) {
  Parts parts;
  parts.radio.agreed_digest = 0xABCE;
  EXPECT_FALSE(parts.standing().agreed);
  parts.radio.agreed_digest = 0xABCD;
  parts.radio.agrees = false;
  EXPECT_FALSE(parts.standing().agreed);
  EXPECT_EQ(parts.standing().waiting, "waiting for the other robots to hold the same map");
}

TEST(Standing, SaysWhomItWaitsForAndSinceWhen) {
  Parts parts;
  parts.team.settled = false;
  parts.team.waiting = {waiting_for("r2", What::records, 12), waiting_for("r3", What::end, 2),
                        waiting_for("r4", What::link), waiting_for("r5", What::solution)};
  EXPECT_EQ(parts.standing().waiting,
            "waiting for r2 (its records), silent for 12 s; r3 (its end); r4 (its links); r5 (the team's solution)");
  EXPECT_FALSE(parts.standing().stuck) << "what is waited for may come";
}

TEST(Standing, AFullStoreCannotBeWaitedOut) {
  Parts parts;
  parts.radio.agrees = false;
  parts.radio.store_full = "the store is full";
  EXPECT_TRUE(parts.standing().stuck);
  EXPECT_THAT(parts.standing().waiting, HasSubstr("the store is full"));
  parts.radio.agrees = true;  // it held what was needed
  EXPECT_FALSE(parts.standing().stuck);
}

TEST(Standing, WhatCannotBeReadCannotBeWaitedOut) {
  Parts parts;
  parts.team.settled = false;
  parts.team.submaps_unread = 3;
  EXPECT_TRUE(parts.standing().stuck);
  EXPECT_EQ(parts.standing().waiting,
            "3 submaps of the map cannot be read from the log: look at the disk under OUT/log");
}

TEST(Refusals, TheTeamsAreCountedBesideTheRadios) {
  Parts parts;
  EXPECT_TRUE(refusals(parts.team, parts.radio).empty());
  parts.radio.refused["stranger"] = 3;
  parts.team.records_refused = 2;
  parts.team.submaps_left_out = 4;
  parts.team.blocks_refused = 5;
  const std::map<std::string, std::uint64_t> expected{
      {"stranger", 3}, {"malformed_record", 2}, {"submap_beyond_budget", 4}, {"global_block_without_room", 5}};
  EXPECT_EQ(refusals(parts.team, parts.radio), expected);
}

}  // namespace
}  // namespace onemap::daemon
