#include "mapping/team/agreement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::link_of;
using What = Waiting::What;

constexpr Instant kStart{};
constexpr Duration kLostAfter = 10s;

// Three robots a, b, c seen by c; who is heard is said by hand.
struct AgreementTest : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c");
  TeamLog log{c.id(), 1};
  Presence presence{c.id(), kLostAfter};
  std::map<RobotId, Instant> last_sign;
  Instant now = kStart;

  void take(const RecordPtr& record) { ASSERT_TRUE(log.apply(record, kStart).ok()); }
  void SetUp() override {
    for (const Author* author : {&a, &b, &c})
      for (const auto& record : author->written()) take(record);
  }
  // Later everybody but these has just been heard.
  Agreement later(Duration by, const std::set<RobotId>& silent = {}, const std::set<RobotId>& complete = {}) {
    now = kStart + by;
    for (const Author* author : {&a, &b, &c})
      if (!silent.contains(author->id())) last_sign[author->id()] = now;
    presence.update(last_sign, complete);
    return {log, presence, now};
  }
  void link_all() {
    take(a.link(link_of("a", "b", 100)));
    take(a.link(link_of("a", "c", 50)));
    take(b.link(link_of("b", "c", 70)));
  }
  static std::string text(const std::vector<Waiting>& waiting) {
    std::string out;
    for (const Waiting& w : waiting) out += w.robot.name() + ":" + std::to_string(static_cast<int>(w.what)) + " ";
    return out;
  }
};

TEST_F(AgreementTest, SaysWhatIsWaitedForAndOfWhom) {
  EXPECT_EQ(text(later(1s).waiting()), "a:1 b:1 ") << "their ends";
  take(a.finish(1));
  take(b.finish());
  take(c.finish());
  EXPECT_EQ(text(later(1s).waiting()), "a:0 b:2 ") << "a record of a, and b's link with c";
  take(a.keyframe());
  EXPECT_EQ(text(later(1s).waiting()), "a:2 b:2 ");
  const auto silent = later(7s, {a.id()}).waiting();
  ASSERT_EQ(silent.size(), 2u);
  EXPECT_EQ(silent[0].silent, Duration(6s));
  EXPECT_EQ(silent[1].silent, Duration::zero());
}

TEST_F(AgreementTest, IsReadyWithEveryPairVerifiedFromAllKeyframes) {
  link_all();
  EXPECT_FALSE(later(1s).ready()) << "they still map";
  for (Author* author : {&a, &b, &c}) take(author->finish());
  EXPECT_TRUE(later(1s).ready());
  EXPECT_TRUE(later(1s).waiting().empty());
  LinkRecord early = link_of("b", "c", 70);
  early.keyframes_b = 2;
  take(b.link(early));
  EXPECT_FALSE(later(1s).ready());
  EXPECT_EQ(text(later(1s).waiting()), "b:2 ");
}

TEST_F(AgreementTest, ARobotThatDiedIsWaitedForAndThenNotAnyMore) {
  link_all();
  take(b.finish());
  take(c.finish());
  const Agreement waits = later(10s, {a.id()});
  EXPECT_EQ(text(waits.waiting()), "a:1 ");
  EXPECT_FALSE(waits.over());
  EXPECT_FALSE(waits.ready());
  const Agreement without = later(11s, {a.id()});
  EXPECT_THAT(without.gone(), testing::ElementsAre(a.id()));
  EXPECT_TRUE(without.over());
  EXPECT_TRUE(without.waiting().empty());
  EXPECT_TRUE(without.ready());
  EXPECT_FALSE(later(12s).over()) << "it came back";
}

// What others hold of it is still waited for.
TEST_F(AgreementTest, OfARobotThatDiedTheRecordsThatAnybodyHasAreWaitedFor) {
  link_all();
  take(b.finish());
  take(c.finish());
  later(11s, {a.id()});
  ASSERT_TRUE(log.apply(a.submap({1, 0, 0}), kStart + 11s).ok());  // came by way of b
  EXPECT_FALSE(later(20s, {a.id()}).gone().contains(a.id())) << "its records are signs of life";
  const Agreement none_missing = later(22s, {a.id()});
  EXPECT_TRUE(none_missing.all_here(a.chain()));
  EXPECT_TRUE(none_missing.ready());
}

TEST_F(AgreementTest, ThePairsOfARobotThatDiedAreTheOthers) {
  EXPECT_EQ(later(1s).verifier(b.chain(), a.chain()), a.id());
  const Agreement without_a = later(12s, {a.id()});
  EXPECT_EQ(without_a.verifier(a.chain(), b.chain()), b.id());
  EXPECT_EQ(without_a.verifier(b.chain(), c.chain()), b.id());
  const Agreement alone = later(24s, {a.id(), b.id()});
  EXPECT_EQ(alone.verifier(a.chain(), b.chain()), std::nullopt);
  EXPECT_TRUE(alone.verified(a.chain(), b.chain())) << "nobody is left to look";
  EXPECT_FALSE(alone.verified(a.chain(), c.chain()));
  EXPECT_EQ(alone.verifier(a.chain(), c.chain()), c.id());
}

TEST_F(AgreementTest, WhoPromisedMoreThanItWroteBlocksNobodyForEver) {
  link_all();
  take(a.finish(4'000'000'000u));
  take(b.finish());
  take(c.finish());
  EXPECT_EQ(text(later(9s, {}, {a.id()}).waiting()), "a:0 ");
  EXPECT_EQ(text(later(11s, {}, {}).waiting()), "a:0 ") << "more of it is known of";
  EXPECT_TRUE(later(11s, {}, {a.id()}).ready());
}

// b was switched off and on: what its earlier life had written counts, and its present one looks at it.
TEST_F(AgreementTest, AnEarlierLifeIsLookedAtByTheLivingAndWaitedForByNobody) {
  link_all();
  Author again = test::small_robot("b", 2);
  for (const auto& record : again.written()) take(record);
  const Agreement team = later(1s);
  EXPECT_EQ(team.chains().size(), 4u);
  EXPECT_TRUE(team.present(again.chain()));
  EXPECT_FALSE(team.present(b.chain()));
  EXPECT_EQ(team.verifier(b.chain(), again.chain()), b.id()) << "its later life";
  EXPECT_EQ(team.verifier(b.chain(), c.chain()), c.id()) << "the one that lives, although it is higher";
  EXPECT_EQ(team.verifier(again.chain(), c.chain()), b.id());
  EXPECT_EQ(text(team.waiting()), "a:1 b:1 ") << "their ends";
  for (Author* author : {&a, &c, &again}) take(author->finish());
  EXPECT_EQ(text(later(1s).waiting()), "a:2 b:0 ") << "links with the new life; b's earlier life may have more";
  const Agreement known = later(2s, {}, {b.id()});
  EXPECT_TRUE(known.all_here(b.chain()));
  EXPECT_EQ(text(known.waiting()), "a:2 b:2 ");
  LinkRecord ab = link_of("a", "b", 80), bb = link_of("b", "b", 70);
  ab.incarnation_other = 2;
  take(a.link(ab));
  take(again.link(bb));
  take(again.link(link_of("b", "c", 60)));
  EXPECT_TRUE(later(3s, {}, {b.id()}).ready());
}

TEST_F(AgreementTest, RobotsWithoutKeyframesHaveNothingToBeLookedAt) {
  link_all();
  for (Author* author : {&a, &b, &c}) take(author->finish());
  Author blind("blind");
  take(blind.hello());
  take(blind.finish());
  presence.update({{blind.id(), kStart + 1s}}, {});
  EXPECT_TRUE(later(1s).ready());
}

}  // namespace
}  // namespace onemap::mapping
