#include "mapping/team/needless_keyframes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

// A robot that looks at some things from some places.
struct Looker {
  Looker() {
    member.incarnation = 1;
    solved.anchors.push_back({0, {}});
  }
  void look_at(std::uint32_t thing, std::chrono::seconds at, double x_m = 0, double turned_rad = 0) {
    KeyframeRecord body;
    body.index = count++;
    body.time = FrameTime{} + at;
    body.T_robot_keyframe = quantize({rotation_about_y(turned_rad), Vector3d(x_m, 0, 0)});
    std::mt19937_64 random(thing);
    for (int i = 0; i < 40; ++i) {
      KeyframeFeature& feature = body.features.emplace_back();
      feature.laplacian = 1;
      for (std::uint64_t& word : feature.bits) word = random();
    }
    EXPECT_TRUE(member.apply(author.write(Lane::features, RecordKind::keyframe, body)).ok());
  }
  static Matrix3d rotation_about_y(double rad) { return Eigen::AngleAxisd(rad, Vector3d::UnitY()).toRotationMatrix(); }
  std::vector<std::size_t> needless() { return keyframes.look(author.id(), member, solved, places); }

  test::Author author{"a"};
  TeamMember member;
  SolvedRobot solved{{RobotId::from_name("a"), 1}, {}};
  std::uint32_t count = 0;
  OwnPlaces places{PlaceIndexConfig{4u << 20}};
  NeedlessKeyframes keyframes;
};

TEST(NeedlessKeyframes, WhatWasSeenAMinuteBeforeIsNeedless) {
  Looker robot;
  robot.look_at(1, 0s);
  robot.look_at(1, 30s);
  EXPECT_THAT(robot.needless(), IsEmpty()) << "the same visit";
  robot.look_at(1, 70s);
  EXPECT_THAT(robot.needless(), ElementsAre(2)) << "what comes back is joined to the first view that there is";
  EXPECT_THAT(robot.needless(), IsEmpty()) << "it is named once";
  robot.look_at(1, 100s);
  EXPECT_THAT(robot.needless(), ElementsAre(3));
}

TEST(NeedlessKeyframes, OnlyFromTheSamePlaceTheSameWayAndWhenItLooksAlike) {
  Looker robot;
  robot.look_at(1, 0s);
  robot.look_at(1, 100s, 0.5);        // farther away
  robot.look_at(1, 100s, 0.0, 0.5);   // another way
  robot.look_at(2, 100s, 0.05, 0.1);  // something else
  EXPECT_THAT(robot.needless(), IsEmpty());
  robot.look_at(1, 110s, 0.05, 0.1);
  EXPECT_THAT(robot.needless(), ElementsAre(4));
}

// What has changed is kept beside what was there, and what looks like either goes.
TEST(NeedlessKeyframes, WhatLooksLikeNothingBeforeIsAViewOfItsOwn) {
  Looker robot;
  robot.look_at(1, 0s);
  robot.look_at(2, 100s);
  EXPECT_THAT(robot.needless(), IsEmpty());
  robot.look_at(2, 200s);
  EXPECT_THAT(robot.needless(), ElementsAre(2));
}

TEST(NeedlessKeyframes, WhatGoesSpeaksForNobody) {
  Looker robot;
  robot.look_at(1, 0s, 0.0);
  robot.look_at(1, 100s, 0.25);
  robot.look_at(1, 200s, 0.5);
  EXPECT_THAT(robot.needless(), ElementsAre(1)) << "the last one is half a metre from the first";
}

TEST(NeedlessKeyframes, OfOneThatWentNothingIsAsked) {
  Looker robot;
  robot.look_at(1, 0s);
  robot.look_at(1, 70s);
  EXPECT_THAT(robot.needless(), ElementsAre(1));
  KeyframeRecord place;
  place.index = 1;
  ASSERT_TRUE(robot.member.apply(robot.author.replacing(1).write(Lane::features, RecordKind::keyframe, place)).ok());
  ++robot.count;
  robot.look_at(1, 140s);
  EXPECT_THAT(robot.needless(), ElementsAre(3));
  EXPECT_EQ(robot.places.index().keyframes(), 2u) << "the one that went is not found any more";
}

}  // namespace
}  // namespace onemap::mapping
