#include "mapping/team/way_on_map.hpp"

#include <gtest/gtest.h>

#include "mapping/team/team_log.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;

FrameTime at(double seconds) { return frame_time_from_ns(static_cast<std::int64_t>(seconds * 1e9)); }

// A robot that stands still for four seconds, with a keyframe at 1 s and one at 3 s, each its own anchor.
struct WayOnMap : testing::Test {
  Author a{"a"};
  TeamLog log{RobotId::from_name("self"), 1};
  SolvedRobot solved;

  void SetUp() override {
    a.hello();
    for (std::uint32_t i = 0; i < 2; ++i) {
      KeyframeRecord keyframe;
      keyframe.index = keyframe.anchor = i;
      keyframe.time = at(1 + 2 * i);
      a.write(Lane::features, RecordKind::keyframe, keyframe);
    }
    TrajectoryRecord poses;
    for (int i = 0; i <= 8; ++i) poses.poses.push_back({at(0.5 * i), {}});
    a.write(Lane::poses, RecordKind::trajectory, poses);
    for (const auto& record : a.written()) ASSERT_TRUE(log.apply(record, Instant{}).ok());
    solved = {a.chain(), {{0, {}}, {1, {}}}};
    solved.anchors[1].T_map_anchor.t_10um[0] = 1000;  // the map has the second a centimetre on
  }
  const TeamMember& member() const { return *log.find(a.id()); }
};

TEST_F(WayOnMap, BendsEvenlyFromAnchorToAnchor) {
  std::vector<std::int32_t> x;
  for (const StampedPose& pose : way_on_map(member(), solved)) x.push_back(pose.T_robot_camera.t_10um[0]);
  EXPECT_EQ(x, (std::vector<std::int32_t>{0, 0, 0, 250, 500, 750, 1000, 1000, 1000}));
}

TEST_F(WayOnMap, KeyframesAndThePresentGoWithTheirAnchors) {
  const auto keyframes = keyframes_on_map(member(), solved);
  ASSERT_EQ(keyframes.size(), 2u);
  EXPECT_EQ(keyframes[0].T_map_keyframe.t_10um[0], 0);
  EXPECT_EQ(keyframes[1].T_map_keyframe.t_10um[0], 1000);
  EXPECT_EQ(correction_now(member(), solved).t_10um[0], 1000);
}

TEST_F(WayOnMap, OfAnotherLifeOrWithoutAnchorsThereIsNone) {
  solved.chain.incarnation = 2;
  EXPECT_TRUE(way_on_map(member(), solved).empty());
  EXPECT_TRUE(keyframes_on_map(member(), solved).empty());
  EXPECT_EQ(correction_now(member(), solved), QuantizedPose{});
  Author b("b");
  b.hello();
  b.pose(1);
  for (const auto& record : b.written()) ASSERT_TRUE(log.apply(record, Instant{}).ok());
  EXPECT_TRUE(way_on_map(*log.find(b.id()), {b.chain(), {}}).empty());
}

}  // namespace
}  // namespace onemap::mapping
