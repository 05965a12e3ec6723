#include "local/tracking/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "support/poses.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

KeyframeMapConfig small_map() { return {20, 500, 0.1, 8}; }

// The parts of a mapper that place frames, without the mapper.
struct TrackingRobot {
  explicit TrackingRobot(const hal::Intrinsics& k)
      : front_end({}, k),
        map(small_map(), k),
        tracker({}, k, front_end.make_observed()),
        seen(front_end.make_observed()) {}

  Placed locate(const hal::Frame& frame) {
    front_end.observe(frame.view(), {}, seen);
    return tracker.locate(seen, map, {});
  }
  // The frame is at T, and a keyframe there.
  void keep(const hal::Frame& frame, const Pose& T_camera_robot) {
    map.add(frame.view(), T_camera_robot, seen.features);
    tracker.follow(seen, frame.colour_time, T_camera_robot);
  }
  FrontEnd front_end;
  KeyframeMap map;
  Tracker tracker;
  Observed seen;
};

std::string room(const std::string& name, int frames = 8) {
  return "simulated:" + name + "?width=320&height=240&frames=" + std::to_string(frames);
}

TEST(Tracker, TheFirstFrameIsWhereTheRobotsFrameIs) {
  test::Stream stream(room("living-room"));
  TrackingRobot robot(stream.intrinsics());
  const Placed placed = robot.locate(*stream.next());
  EXPECT_EQ(placed.reason, TrackReason::first_frame);
  EXPECT_TRUE(placed.ok());
  EXPECT_EQ(placed.T_camera_robot.t, Vector3d::Zero());
  EXPECT_GE(placed.inliers, 20);
  EXPECT_EQ(robot.tracker.state(), TrackState::starting) << "until somebody says that it was followed";
}

TEST(Tracker, TheNextFramesArePlacedWhereTheyAre) {
  test::Stream stream(room("living-room"));
  TrackingRobot robot(stream.intrinsics());
  const auto first = stream.next();
  robot.locate(*first);
  robot.keep(*first, Pose{});
  for (std::size_t i = 1; i < 8; ++i) {
    const auto frame = stream.next();
    const Placed placed = robot.locate(*frame);
    ASSERT_EQ(placed.reason, TrackReason::ok) << i;
    const Pose truth = test::truth_pose(stream.truth[i]).inverse() * test::truth_pose(stream.truth[0]);
    EXPECT_LT((placed.T_camera_robot.inverse() * truth).t.norm(), 0.02) << i;
    EXPECT_EQ(robot.tracker.last_matches(robot.seen, robot.map).matches.size(),
              static_cast<std::size_t>(placed.matches));
    robot.tracker.follow(robot.seen, frame->colour_time, placed.T_camera_robot);
    EXPECT_EQ(robot.tracker.state(), TrackState::tracking);
  }
}

TEST(Tracker, AnImageWithoutFeaturesIsComparedWithNothing) {
  test::Stream stream(room("living-room"));
  TrackingRobot robot(stream.intrinsics());
  auto frame = stream.next();
  robot.locate(*frame);
  robot.keep(*frame, Pose{});
  frame = stream.next();
  std::fill(frame->rgb().begin(), frame->rgb().end(), std::uint8_t{90});
  EXPECT_EQ(robot.locate(*frame).reason, TrackReason::too_few_features);
  EXPECT_EQ(robot.tracker.last_matches(robot.seen, robot.map).frame, nullptr);
}

// The last frame and the reference are of another room: only an earlier keyframe can place this one, and only a lost
// camera looks there.
TEST(Tracker, ALostCameraIsPlacedByAnEarlierKeyframe) {
  test::Stream here(room("living-room")), elsewhere(room("storage"));
  TrackingRobot robot(here.intrinsics());
  const auto first = here.next(), other = elsewhere.next();
  robot.locate(*first);
  robot.keep(*first, Pose{});
  const Pose far{Matrix3d::Identity(), {50, 0, 0}};
  robot.front_end.observe(other->view(), {}, robot.seen);
  robot.keep(*other, far);
  const std::size_t of_storage = robot.map.reference_slot();

  const auto again = here.next();
  EXPECT_FALSE(robot.locate(*again).ok()) << "the camera is not lost yet";
  EXPECT_EQ(robot.map.reference_slot(), of_storage);
  robot.tracker.lose();
  EXPECT_EQ(robot.tracker.state(), TrackState::lost);
  const Placed placed = robot.locate(*again);
  ASSERT_EQ(placed.reason, TrackReason::ok);
  EXPECT_LT(placed.T_camera_robot.t.norm(), 0.1);
  EXPECT_EQ(robot.map.reference().time, first->colour_time);
  EXPECT_EQ(robot.tracker.last_matches(robot.seen, robot.map).other_time, first->colour_time);

  test::Stream nowhere(room("corridor"));
  const std::size_t reference = robot.map.reference_slot();
  EXPECT_FALSE(robot.locate(*nowhere.next()).ok());
  EXPECT_EQ(robot.map.reference_slot(), reference) << "a search in vain leaves the reference";
}

TEST(Tracker, AMotionThatNoCameraMakesIsRefused) {
  test::Stream stream(room("living-room"));
  TrackingRobot robot(stream.intrinsics());
  const auto first = stream.next();
  robot.locate(*first);
  robot.keep(*first, Pose{});
  robot.front_end.observe(first->view(), {}, robot.seen);
  // The camera is said to be 2 m from where its only keyframe says.
  robot.tracker.follow(robot.seen, first->colour_time, Pose{Matrix3d::Identity(), {2, 0, 0}});
  const Placed placed = robot.locate(*stream.next());
  EXPECT_FALSE(placed.ok());
  EXPECT_EQ(placed.reason, TrackReason::inconsistent_motion);
}

}  // namespace
}  // namespace onemap::mapping
