#include "mapping/team/presence.hpp"

#include <gtest/gtest.h>

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;

const RobotId kSelf = RobotId::from_name("self"), kOther = RobotId::from_name("other");
constexpr Instant kStart{};

TEST(Presence, ARobotIsGoneWhenItWasSilentForTooLong) {
  Presence presence(kSelf, 10s);
  TeamMember member;
  member.heard = kStart;
  EXPECT_FALSE(presence.gone(kOther, member, kStart + 10s));
  EXPECT_TRUE(presence.gone(kOther, member, kStart + 11s));
  presence.update({{kOther, kStart + 5s}}, {});
  EXPECT_FALSE(presence.gone(kOther, member, kStart + 11s));
  EXPECT_EQ(presence.silent(kOther, member, kStart + 11s), Duration(6s));
  EXPECT_TRUE(presence.gone(kOther, member, kStart + 16s));
  presence.update({{kOther, kStart + 20s}}, {});
  EXPECT_FALSE(presence.gone(kOther, member, kStart + 21s)) << "it came back";
}

TEST(Presence, ItsRecordsAreSignsOfLifeToo) {
  Presence presence(kSelf, 10s);
  presence.update({{kOther, kStart}}, {});
  TeamMember member;
  member.heard = kStart + 9s;
  EXPECT_FALSE(presence.gone(kOther, member, kStart + 12s));
}

TEST(Presence, NobodyIsGoneBecauseThisRobotDidNotListen) {
  Presence presence(kSelf, 10s);
  TeamMember member;
  member.heard = kStart;
  presence.update({{kOther, kStart + 4s}, {kSelf, kStart + 5s}}, {});
  EXPECT_FALSE(presence.gone(kOther, member, kStart + 3600s));
  EXPECT_EQ(presence.silent(kOther, member, kStart + 3600s), Duration(1s));
  presence.update({{kOther, kStart + 4s}, {kSelf, kStart + 15s}}, {});
  EXPECT_TRUE(presence.gone(kOther, member, kStart + 3600s));
}

TEST(Presence, ThisRobotIsAlwaysHere) {
  Presence presence(kSelf, 10s);
  EXPECT_FALSE(presence.gone(kSelf, {}, kStart + 1000s));
}

TEST(Presence, KnowsWhenNothingMoreIsOnItsWay) {
  Presence presence(kSelf, 10s);
  TeamMember member;
  member.heard = kStart;
  EXPECT_FALSE(presence.quiet(member, kStart + 10s));
  EXPECT_TRUE(presence.quiet(member, kStart + 11s));
  EXPECT_FALSE(presence.all_known_here(kOther));
  presence.update({}, {kOther});
  EXPECT_TRUE(presence.all_known_here(kOther));
}

}  // namespace
}  // namespace onemap::mapping
