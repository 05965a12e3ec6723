#include "mapping/local/local_mapper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <span>

#include "support/count_allocations.hpp"
#include "support/stream.hpp"
#include "support/submap_digest.hpp"

namespace onemap::mapping {
namespace {

using test::Stream;
using test::truth_pose;

LocalMapperConfig small_config() {
  LocalMapperConfig config;
  config.max_keyframes = 40;
  config.map.budget_bytes = 24u << 20;
  return config;
}

struct Walk {
  std::vector<StampedPose> poses;
  std::vector<KeyframeRecord> keyframes;
  std::uint64_t digest = 0;
  LocalMapperCounters counters;
  std::vector<FrameReport> reports;
};

// Plays a stream through a mapper; change may alter a frame before it is processed.
Walk play(const std::string& address, const LocalMapperConfig& config,
          const std::function<void(hal::Frame&)>& change = {}) {
  Stream stream(address);
  LocalMapper mapper(config, stream.camera->intrinsics());
  Walk walk;
  KeyframeRecord keyframe;
  TrajectoryRecord poses;
  const auto drain = [&] {
    while (mapper.take_keyframe(keyframe)) walk.keyframes.push_back(keyframe);
    while (mapper.take_poses(poses)) walk.poses.insert(walk.poses.end(), poses.poses.begin(), poses.poses.end());
  };
  while (auto frame = stream.next()) {
    if (change) change(*frame);
    walk.reports.push_back(mapper.process(frame->view()));
    drain();
  }
  mapper.finish();
  drain();
  walk.digest = test::submap_digest(mapper);
  walk.counters = mapper.counters();
  return walk;
}

// Root mean square distance of the camera positions from the truth, both seen from the first camera.
double position_error_m(const std::vector<StampedPose>& poses, const std::vector<hal::SimulatedPose>& truth) {
  const Pose T_first_world = truth_pose(truth.front()).inverse();
  double sum = 0;
  std::size_t n = 0, k = 0;
  for (const StampedPose& p : poses) {
    while (k < truth.size() && truth[k].time < p.time) ++k;
    if (k == truth.size() || truth[k].time != p.time) continue;
    sum += (from_quantized(p.T_robot_camera).t - (T_first_world * truth_pose(truth[k])).t).squaredNorm();
    ++n;
  }
  return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : 1e9;
}

TEST(LocalMapper, FollowsASimulatedWalkThroughNoise) {
  const std::string address = "simulated:living-room?frames=90&seed=3";
  const Walk walk = play(address, small_config());
  EXPECT_EQ(walk.counters.frames, 90u);
  EXPECT_EQ(walk.counters.tracked, 90u);
  EXPECT_EQ(walk.poses.size(), 90u) << "every tracked frame has one pose after finish()";
  EXPECT_EQ(walk.keyframes.size(), walk.counters.keyframes);
  EXPECT_GE(walk.keyframes.size(), 3u);
  EXPECT_LT(position_error_m(walk.poses, Stream(address).truth), 0.02);
}

TEST(LocalMapper, PosesComeOutInOrderOfTime) {
  const Walk walk = play("simulated:office?frames=60", small_config());
  for (std::size_t i = 1; i < walk.poses.size(); ++i) EXPECT_LT(walk.poses[i - 1].time, walk.poses[i].time);
}

TEST(LocalMapper, SameFramesGiveTheSameBytes) {
  const std::string address = "simulated:living-room?frames=40&robot=2&width=320&height=240";
  const Walk a = play(address, small_config()), b = play(address, small_config());
  EXPECT_EQ(a.digest, b.digest);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) EXPECT_EQ(a.poses[i].T_robot_camera, b.poses[i].T_robot_camera);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) EXPECT_EQ(encode(a.keyframes[i]), encode(b.keyframes[i]));
}

std::uint64_t fnv1a(std::uint64_t hash, std::uint8_t byte) { return (hash ^ byte) * 0x100000001b3u; }

// Everything that leaves the robot, in one number.
std::uint64_t digest_of(const Walk& walk) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&hash](std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) hash = fnv1a(hash, byte);
  };
  for (const KeyframeRecord& keyframe : walk.keyframes) mix(encode(keyframe));
  TrajectoryRecord trajectory;
  trajectory.poses = walk.poses;
  mix(encode(trajectory));
  for (int shift = 0; shift < 64; shift += 8) hash = fnv1a(hash, static_cast<std::uint8_t>(walk.digest >> shift));
  return hash;
}

// The numbers are what a release build on x86-64 gives: optimised, debug and sanitizer builds must all give them, on
// any machine. A change of the algorithms changes them too; then take the new ones from the release build.
TEST(LocalMapper, EveryBuildGivesTheSameBytes) {
  const Walk walk = play("simulated:living-room?frames=40&robot=2&width=320&height=240", small_config());
  EXPECT_GE(walk.counters.tracked, 38u);
  EXPECT_EQ(walk.digest, 12562742069788022076u) << "the map";
  EXPECT_EQ(digest_of(walk), 11025215249411112340u) << "keyframes, trajectory and map";
}

TEST(LocalMapper, AllocatesNothingOnTheFramePath) {
  Stream stream("simulated:living-room?frames=60");
  const LocalMapperConfig config = small_config();
  LocalMapper mapper(config, stream.camera->intrinsics());
  KeyframeRecord keyframe;
  LocalMapper::reserve_record(keyframe, config);
  TrajectoryRecord poses;
  poses.poses.reserve(256);
  std::vector<hal::Frame> frames;
  std::uint64_t allocated = 0, keyframes = 0;
  while (auto frame = stream.next()) {
    const std::uint64_t before = test::allocations();
    keyframes += mapper.process(frame->view()).keyframe_added;
    while (mapper.take_keyframe(keyframe)) {
    }
    while (mapper.take_poses(poses)) {
    }
    allocated += test::allocations() - before;
  }
  EXPECT_GE(keyframes, 2u);
  EXPECT_EQ(allocated, 0u);
}

TEST(LocalMapper, LostIsAStateThatIsCountedAndTrackingResumes) {
  int n = 0;
  const auto blind = [&](hal::Frame& frame) {
    if (n >= 30 && n < 36) std::fill(frame.rgb().begin(), frame.rgb().end(), std::uint8_t{128});
    ++n;
  };
  const Walk walk = play("simulated:living-room?frames=60", small_config(), blind);
  EXPECT_EQ(walk.counters.times_lost, 1u);
  EXPECT_EQ(walk.counters.lost, 6u);
  EXPECT_EQ(walk.counters.relocalized, 1u);
  EXPECT_EQ(walk.counters.tracked, 54u);
  EXPECT_EQ(walk.counters.refused[static_cast<std::size_t>(TrackReason::too_few_features)], 6u);
  EXPECT_EQ(walk.reports[30].state, TrackState::lost);
  EXPECT_TRUE(walk.reports[36].relocalized);
  EXPECT_LT(position_error_m(walk.poses, Stream("simulated:living-room?frames=60").truth), 0.02);
}

TEST(LocalMapper, DepthlessFramesAreRefusedWithTheirReason) {
  const auto no_depth = [](hal::Frame& frame) {
    std::fill(frame.depth().begin(), frame.depth().end(), std::uint16_t{0});
  };
  const Walk walk = play("simulated:living-room?frames=5", small_config(), no_depth);
  EXPECT_EQ(walk.counters.tracked, 0u);
  EXPECT_EQ(walk.counters.refused[static_cast<std::size_t>(TrackReason::depth_incoherent)], 5u);
  EXPECT_EQ(walk.counters.times_lost, 0u) << "it never had a place to lose";
}

// One bad time stamp costs its frame and nothing else: the frames after it are tracked as if it had not been.
TEST(LocalMapper, AFrameWhoseTimeDoesNotIncreaseIsRefusedAndLeavesNoTrace) {
  const std::string address = "simulated:living-room?frames=20&width=320&height=240";
  Stream stream(address);
  const LocalMapperConfig config = small_config();
  LocalMapper mapper(config, stream.camera->intrinsics()), clean(config, stream.camera->intrinsics());
  while (auto frame = stream.next()) {
    clean.process(frame->view());
    mapper.process(frame->view());
    for (const auto step : {std::chrono::milliseconds(0), std::chrono::milliseconds(1000)}) {
      hal::FrameView late = frame->view();
      late.colour_time -= step;
      const FrameReport report = mapper.process(late);
      EXPECT_EQ(report.reason, TrackReason::time_not_increasing);
      EXPECT_EQ(report.state, TrackState::tracking);
      EXPECT_EQ(mapper.last_matches().frame, nullptr) << "the matches are another frame's";
    }
  }
  EXPECT_EQ(mapper.counters().refused[static_cast<std::size_t>(TrackReason::time_not_increasing)], 2u * 20u);
  EXPECT_EQ(mapper.counters().times_lost, 0u);
  EXPECT_EQ(mapper.counters().tracked, 20u);
  EXPECT_EQ(test::submap_digest(mapper), test::submap_digest(clean));
  mapper.finish();
  clean.finish();
  TrajectoryRecord a, b;
  ASSERT_TRUE(mapper.take_poses(a));
  ASSERT_TRUE(clean.take_poses(b));
  EXPECT_EQ(encode(a), encode(b));
}

TEST(LocalMapper, KeyframePoolThatIsFullEvictsAndGoesOn) {
  LocalMapperConfig config = small_config();
  config.max_keyframes = 12;
  config.keyframe_translation_m = 0.03;
  config.keyframe_rotation_deg = 2;
  const Walk walk = play("simulated:living-room?frames=120&width=320&height=240", config);
  EXPECT_GT(walk.counters.keyframes_evicted, 0u);
  EXPECT_EQ(walk.counters.keyframes_in_map(), 12u);
  EXPECT_EQ(walk.counters.tracked, 120u);
  EXPECT_EQ(walk.keyframes.size(), walk.counters.keyframes) << "an evicted keyframe has left as a record before";
}

// There and back again with the smallest pool: on the way back the reference is a keyframe that the window has left.
TEST(LocalMapper, TheSmallestKeyframePoolWorks) {
  LocalMapperConfig config = small_config();
  config.max_keyframes = kMinKeyframes;
  config.keyframe_translation_m = 0.02;
  config.keyframe_rotation_deg = 1;
  for (const bool taking : {true, false}) {
    Stream stream("simulated:living-room?frames=60&width=320&height=240");
    hal::FramePool all(stream.camera->intrinsics(), 61);
    std::vector<hal::Frame> frames;
    for (;;) {
      hal::Frame frame = all.acquire();
      if (stream.camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
      frames.push_back(std::move(frame));
    }
    ASSERT_EQ(frames.size(), 60u);
    LocalMapper mapper(config, stream.camera->intrinsics());
    KeyframeRecord record;
    std::uint32_t taken = 0;
    std::int64_t last = -1;
    const auto take = [&] {
      for (; mapper.take_keyframe(record); ++taken) {
        EXPECT_GT(std::int64_t{record.index}, last);
        last = record.index;
      }
    };
    for (std::size_t i = 0; i < 118; ++i) {
      hal::FrameView view = frames[i < 60 ? i : 118 - i].view();
      view.colour_time = view.depth_time = frames[0].colour_time + std::chrono::milliseconds(33 * (i + 1));
      EXPECT_EQ(mapper.process(view).state, TrackState::tracking) << i;
      if (taking) take();
    }
    mapper.finish();
    take();
    const LocalMapperCounters c = mapper.counters();
    EXPECT_GT(c.keyframes, 30u);
    EXPECT_EQ(taken + c.keyframes_untaken, c.keyframes);
    EXPECT_EQ(c.keyframes_untaken == 0, taking);
  }
}

TEST(LocalMapper, AFullMapIsSaidWhileItRuns) {
  LocalMapperConfig config = small_config();
  config.map.budget_bytes = 2u << 20;
  Stream stream("simulated:living-room?frames=10&width=320&height=240");
  LocalMapper mapper(config, stream.camera->intrinsics());
  LocalMapperCounters c;
  while (auto frame = stream.next()) {
    const LocalMapperCounters before = c;
    const bool integrated = mapper.process(frame->view()).integrated;
    c = mapper.counters();
    EXPECT_EQ(c.surface.frames_short, before.surface.frames_short + integrated);
    EXPECT_EQ(c.surface.blocks_refused > before.surface.blocks_refused, integrated);
  }
  EXPECT_GT(c.blocks, 100u);
  EXPECT_EQ(c.keyframes_in_map(), c.keyframes);
}

// Its pose becomes final by age, also while the camera sees nothing: the team waits for it.
TEST(LocalMapper, AKeyframeComesOutSoonWhateverTheCameraDoes) {
  for (const bool covered : {false, true}) {
    Stream stream("simulated:living-room?frames=1&width=320&height=240");
    LocalMapper mapper(small_config(), stream.camera->intrinsics());
    auto frame = stream.next();
    const FrameTime begin = frame->colour_time;
    KeyframeRecord keyframe;
    int out_at_ms = 0;
    for (int ms = 0; ms < 3000 && out_at_ms == 0; ms += 100) {
      frame->colour_time = frame->depth_time = begin + std::chrono::milliseconds(ms);
      if (covered && ms > 0) std::fill(frame->rgb().begin(), frame->rgb().end(), std::uint8_t{0});
      if (covered && ms > 0) std::fill(frame->depth().begin(), frame->depth().end(), std::uint16_t{0});
      mapper.process(frame->view());
      if (mapper.take_keyframe(keyframe)) out_at_ms = ms;
    }
    EXPECT_EQ(out_at_ms, 1600) << (covered ? "covered" : "standing still");
    EXPECT_EQ(keyframe.index, 0u);
  }
}

// Figure 4: between frames that are close in time, a kept match joins places that are close in the image.
TEST(LocalMapper, MatchesForPicturesBelongToTheImagesThatTheyName) {
  Stream stream("simulated:living-room?frames=12&width=320&height=240");
  LocalMapper mapper(small_config(), stream.camera->intrinsics());
  FrameTime last{};
  int pictures = 0;
  while (auto frame = stream.next()) {
    mapper.process(frame->view());
    const auto picture = mapper.last_matches();
    if (picture.frame != nullptr) {
      ++pictures;
      EXPECT_EQ(picture.other_time, last);
      for (std::size_t i = 0; i < picture.matches.size(); ++i) {
        if (!picture.kept[i]) continue;
        const Keypoint &a = picture.frame->keypoints[picture.matches[i].a],
                       &b = picture.other->keypoints[picture.matches[i].b];
        ASSERT_LT(std::hypot(a.x_px - b.x_px, a.y_px - b.y_px), 25);
      }
    }
    last = frame->colour_time;
  }
  EXPECT_EQ(pictures, 11);
}

// A frame without features was compared with nothing, so there is no picture of it.
TEST(LocalMapper, AFrameThatWasNotComparedHasNoMatches) {
  Stream stream("simulated:living-room?frames=4&width=320&height=240");
  LocalMapper mapper(small_config(), stream.camera->intrinsics());
  for (int n = 0; auto frame = stream.next(); ++n) {
    if (n == 3) std::fill(frame->rgb().begin(), frame->rgb().end(), std::uint8_t{128});
    mapper.process(frame->view());
    EXPECT_EQ(mapper.last_matches().frame != nullptr, n == 1 || n == 2) << n;
  }
}

TEST(LocalMapper, OrbIsAnAlternative) {
  LocalMapperConfig config = small_config();
  config.features = DescriptorKind::orb;
  const std::string address = "simulated:living-room?frames=40";
  const Walk walk = play(address, config);
  EXPECT_EQ(walk.counters.tracked, 40u);
  EXPECT_LT(position_error_m(walk.poses, Stream(address).truth), 0.03);
}

}  // namespace
}  // namespace onemap::mapping
