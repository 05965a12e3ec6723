// Where colour has little to say: a mapper in a room of bare walls, and what must not be taken for one.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "mapping/local/local_mapper.hpp"
#include "support/count_allocations.hpp"
#include "support/stream.hpp"

namespace onemap::mapping {
namespace {

struct Walk {
  std::vector<FrameReport> reports;
  std::vector<hal::SimulatedPose> truth;
  LocalMapperCounters counters;
  std::uint64_t allocations = 0;  // within process()
};

Walk play(const std::string& address, const std::function<void(std::size_t, hal::Frame&)>& change = {}) {
  test::Stream stream(address);
  LocalMapper mapper({}, stream.intrinsics());
  Walk walk;
  KeyframeRecord keyframe;
  TrajectoryRecord poses;
  SubmapRecord submap;
  walk.reports.reserve(stream.truth.size());
  for (std::size_t n = 0; auto frame = stream.next(); ++n) {
    if (change) change(n, *frame);
    const std::uint64_t before = test::allocations();
    walk.reports.push_back(mapper.process(frame->view()));
    walk.allocations += test::allocations() - before;
    while (mapper.take_keyframe(keyframe)) {
    }
    while (mapper.take_poses(poses)) {
    }
    while (mapper.take_submap(submap)) {
    }
  }
  walk.truth = std::move(stream.truth);
  walk.counters = mapper.counters();
  return walk;
}

// How far the camera is from where it truly is, seen from the first frame.
double off_m(const Walk& walk, std::size_t n) {
  const Pose truth = test::truth_pose(walk.truth[0]).inverse() * test::truth_pose(walk.truth[n]);
  return (walk.reports[n].T_robot_camera.t - truth.t).norm();
}

double way_m(const Walk& walk) {
  double sum = 0;
  for (std::size_t n = 1; n < walk.truth.size(); ++n)
    sum += (test::truth_pose(walk.truth[n]).t - test::truth_pose(walk.truth[n - 1]).t).norm();
  return sum;
}

std::uint64_t refused(const Walk& walk, TrackReason reason) {
  return walk.counters.refused[static_cast<std::size_t>(reason)];
}

// Once round the room. Without alignment of the two ways, so stricter than an ATE; 1 % of the way.
TEST(BlankWalls, TheWayRoundIsTrackedToOnePercent) {
  const Walk walk = play("simulated:blank-walls?frames=620");
  EXPECT_EQ(walk.counters.tracked, 620u);
  double squares = 0;
  int poor = 0;
  for (std::size_t n = 0; n < walk.reports.size(); ++n) {
    squares += off_m(walk, n) * off_m(walk, n);
    poor += walk.reports[n].features < 30;
  }
  EXPECT_LT(std::sqrt(squares / 620), 0.01 * way_m(walk));
  EXPECT_GT(poor, 500) << "the room is not blank";
  EXPECT_GT(walk.counters.keyframes, 40u);
  EXPECT_LT(walk.counters.surface.submaps, 16u) << "keyframes without features hang on anchors all the same";
  EXPECT_EQ(walk.allocations, 0u);
}

TEST(BlankWalls, ARobotMayStartBeforeOne) {
  const Walk walk = play("simulated:blank-walls?frames=60&robot=3");
  EXPECT_LT(walk.reports[0].features, 15);
  EXPECT_EQ(walk.reports[0].reason, TrackReason::first_frame);
  EXPECT_EQ(walk.counters.tracked, 60u);
  EXPECT_LT(off_m(walk, 59), 0.03);
}

// From frame 60 on the camera stands before a wall, and its motion before would have gone on.
TEST(BlankWalls, ADirectionThatNothingSeesIsLostAfterAWhile) {
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> rgb;
  const auto stand = [&](std::size_t n, hal::Frame& frame) {
    if (n == 145) {
      depth.assign(frame.depth().begin(), frame.depth().end());
      rgb.assign(frame.rgb().begin(), frame.rgb().end());
    }
    if (n <= 145) return;
    std::ranges::copy(depth, frame.depth().begin());
    std::ranges::copy(rgb, frame.rgb().begin());
  };
  const Walk walk = play("simulated:blank-walls?frames=200", stand);
  for (std::size_t n = 0; n < 150; ++n) EXPECT_EQ(walk.reports[n].state, TrackState::tracking) << n;
  EXPECT_GT(refused(walk, TrackReason::direction_unseen), 0u);
  EXPECT_EQ(walk.reports[199].state, TrackState::lost);
}

// Covered for six frames: black, of one brightness, or without depth. The first two tell of a cover though depth is
// there. The camera goes on where it is.
TEST(BlankWalls, ACoveredCameraIsLost) {
  for (const int cover : {0, 1, 2}) {
    const auto covered = [&](std::size_t n, hal::Frame& frame) {
      if (n < 30 || n >= 36) return;
      if (cover == 0) std::ranges::fill(frame.rgb(), std::uint8_t{0});
      if (cover == 1) std::ranges::fill(frame.rgb(), std::uint8_t{120});
      if (cover == 2) std::ranges::fill(frame.depth(), std::uint16_t{0});
    };
    const Walk walk = play("simulated:blank-walls?frames=60&robot=3", covered);
    EXPECT_EQ(walk.counters.lost, 6u) << cover;
    EXPECT_EQ(walk.reports[30].state, TrackState::lost) << cover;
    EXPECT_EQ(walk.reports[36].state, TrackState::tracking) << cover;
    EXPECT_LT(off_m(walk, 59), 0.04) << cover;
  }
}

// Another room from one frame to the next, as bare or furnished: depth that does not fit is no place.
TEST(BlankWalls, AnotherPlaceIsLost) {
  for (const std::string elsewhere :
       {"living-room?", "corridor?", "blank-walls?seed=9&", "blank-walls?seed=5&robot=2&", "empty-hall?"}) {
    test::Stream other("simulated:" + elsewhere + "frames=30");
    const auto moved = [&](std::size_t n, hal::Frame& frame) {
      if (n < 30) return;
      const auto there = other.next();
      std::ranges::copy(there->view().rgb, frame.rgb().begin());
      std::ranges::copy(there->view().depth, frame.depth().begin());
    };
    const Walk walk = play("simulated:blank-walls?frames=60&robot=3", moved);
    EXPECT_EQ(walk.counters.tracked, 30u) << elsewhere;
  }
}

// A textured place whose image stops to fit is lost as ever, though its depth goes on to.
TEST(BlankWalls, ATexturedPlaceIsNotFollowedByDepthAgainstItsColours) {
  test::Stream other("simulated:storage?frames=20");
  const auto painted = [&](std::size_t n, hal::Frame& frame) {
    if (n < 20) return;
    std::ranges::copy(other.next()->view().rgb, frame.rgb().begin());
  };
  const Walk walk = play("simulated:living-room?frames=40", painted);
  EXPECT_EQ(walk.counters.tracked, 20u);
  const auto bare = [](std::size_t n, hal::Frame& frame) {
    if (n < 20) return;
    for (std::size_t i = 0; i < frame.rgb().size(); ++i)
      frame.rgb()[i] = static_cast<std::uint8_t>(120 + (i * 2654435761u >> 7) % 5);
  };
  EXPECT_EQ(play("simulated:living-room?frames=40", bare).counters.tracked, 20u);
}

}  // namespace
}  // namespace onemap::mapping
