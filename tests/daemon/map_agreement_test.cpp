#include "daemon/map_agreement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;

const RobotId kA = RobotId::from_name("a"), kB = RobotId::from_name("b");
constexpr Instant kBegan{};

struct MapAgreementTest : testing::Test {
  MapAgreement agreement;
  TeamView team;
  RadioView radio;

  void SetUp() override { team.greeted = {kA, kB}; }

  void has(std::uint64_t digest) {
    team.digest = digest;
    team.digests.push_back(digest);
  }
  bool at(Duration by) {
    agreement.look(team, radio, kBegan + by);
    return agreement.agreed();
  }
};

TEST_F(MapAgreementTest, ARobotAloneAgreesOnceItHasAMap) {
  EXPECT_FALSE(at(0s));
  has(1);
  EXPECT_TRUE(at(1s));
}

TEST_F(MapAgreementTest, OthersMayBeAMomentBehindOrAhead) {
  has(1);
  radio.map_digests = {{kA, 1}, {kB, 0}};
  EXPECT_FALSE(at(0s));
  EXPECT_THAT(agreement.differing(), testing::ElementsAre(kB)) << "it has none yet";
  radio.map_digests[kB] = 1;
  EXPECT_TRUE(at(1s));
  has(2);
  EXPECT_TRUE(at(2s)) << "both are behind";
  radio.map_digests = {{kA, 3}, {kB, 2}};
  EXPECT_TRUE(at(3s)) << "a is ahead";
  EXPECT_TRUE(at(6s));
  EXPECT_FALSE(at(8s)) << "for too long to be ahead";
  EXPECT_THAT(agreement.differing(), testing::ElementsAre(kA));
  has(3);
  EXPECT_TRUE(at(9s));
}

TEST_F(MapAgreementTest, OfWhomThereIsABeaconAndNoHelloIsNotAsked) {
  has(1);
  team.greeted = {kA};
  radio.map_digests = {{kA, 1}, {kB, 0}};
  EXPECT_TRUE(at(0s));
  team.greeted = {kA, kB};
  EXPECT_FALSE(at(10s));
  EXPECT_THAT(agreement.differing(), testing::ElementsAre(kB));
}

TEST_F(MapAgreementTest, WhoIsGoneIsNotAsked) {
  has(1);
  radio.map_digests = {{kA, 1}, {kB, 77}};
  EXPECT_FALSE(at(0s));
  team.gone.insert(kB);
  EXPECT_TRUE(at(1s));
}

}  // namespace
}  // namespace onemap::daemon
