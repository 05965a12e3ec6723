// The capture thread with a camera that follows a script: what is delivered, counted and said.
#include "daemon/capture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <semaphore>

#include "daemon/clock.hpp"

#include "hal/backends/simulated.hpp"

namespace onemap::daemon {
namespace {

using hal::Grab;
using testing::HasSubstr;

// Answers what its script says, and `end` when that is over.
class ScriptedCamera final : public hal::DepthCamera {
 public:
  explicit ScriptedCamera(std::deque<Grab> script) : script_(std::move(script)) {
    intrinsics_.width = 4;
    intrinsics_.height = 3;
  }
  const hal::Intrinsics& intrinsics() const override { return intrinsics_; }
  Grab grab(hal::Frame& into, std::chrono::milliseconds) override {
    if (script_.empty()) return Grab::end;
    const Grab grab = script_.front();
    script_.pop_front();
    if (grab == Grab::frame) {
      into.index = frames_++;
      into.colour_time = into.depth_time = FrameTime(std::chrono::milliseconds(33 * frames_));
    }
    if (grab == Grab::gone) error_ = {"/dev/camera", "unplugged " + std::to_string(++unplugged_)};
    if (grab == Grab::bad) error_ = {"/dev/camera", "torn " + std::to_string(++bad_)};
    if (grab == Grab::timeout) ++waits_;
    return grab;
  }
  const Error& last_error() const override { return error_; }
  // As if each bad frame left an image without its partner, and each wait missed two frames.
  hal::CameraCounters counters() const override { return {frames_, bad_, 1 + bad_, 2 * waits_}; }
  bool live() const override { return true; }
  std::uint64_t frames_expected() const override { return 0; }
  // At a slow socket after the first time that it is unplugged, at the first one again after the second.
  std::string description() const override { return unplugged_ == 1 ? "scripted, at another socket" : "scripted"; }
  std::string limits() const override { return unplugged_ == 1 ? "is on USB 2" : ""; }

 private:
  hal::Intrinsics intrinsics_;
  std::deque<Grab> script_;
  Error error_;
  std::uint64_t frames_ = 0, bad_ = 0, waits_ = 0;
  int unplugged_ = 0;
};

struct Played {
  std::vector<std::uint64_t> frames;
  CaptureCounters counters;
  CameraWords words;
  bool ended = false;
  std::string log;
};

Played play(std::deque<Grab> script) {
  ScriptedCamera camera(std::move(script));
  Failures failures;
  Log log("robot");
  Played played;
  testing::internal::CaptureStderr();
  {
    Capture capture(camera, {true, 1}, failures, log);
    capture.start();
    while (auto frame = capture.frames().pop()) played.frames.push_back(frame->index);
    capture.stop();
    played.counters = capture.counters();
    played.words = capture.words();
    played.ended = capture.ended();
  }
  played.log = testing::internal::GetCapturedStderr();
  return played;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Capture, AGoneCameraIsWaitedForAndSaidOnceEachTime) {
  using enum Grab;
  const Played played = play({frame, gone, gone, timeout, gone, frame, frame, gone, frame, end});
  EXPECT_THAT(played.frames, testing::ElementsAre(0u, 1u, 2u, 3u));
  EXPECT_EQ(played.counters.grabbed, 4u);
  EXPECT_EQ(played.counters.gone, 2u);
  EXPECT_EQ(played.counters.bad, 0u);
  EXPECT_TRUE(played.ended);
  EXPECT_EQ(count(played.log, "the camera is gone: /dev/camera: unplugged"), 2u) << played.log;
  EXPECT_THAT(played.log, HasSubstr("unplugged 1;"));
  EXPECT_THAT(played.log, HasSubstr("unplugged 4;"));
  EXPECT_EQ(count(played.log, "the camera is back"), 2u) << played.log;
}

// It is at a port that is too slow for it, or another is in its place: nobody would look there for a cable.
TEST(Capture, WhyACameraDoesNotComeBackIsSaidWhenItIsAnotherReason) {
  using enum Grab;
  const std::string log = play({frame, gone, gone, gone, frame}).log;
  EXPECT_EQ(count(log, "the camera is gone: /dev/camera: unplugged 1; waiting for it"), 1u) << log;
  EXPECT_EQ(count(log, "the camera is still gone: /dev/camera: unplugged 2\n"), 1u) << log;
  EXPECT_EQ(count(log, "the camera is still gone"), 1u) << "once a second at most: " << log;
  EXPECT_THAT(play({frame, gone, frame}).log, testing::Not(HasSubstr("still gone")));
}

TEST(Capture, WhatTheCameraSaysOfItselfIsReadAnewWhenItIsBack) {
  using enum Grab;
  const Played once = play({frame, gone, frame, frame});
  EXPECT_EQ(once.words, (CameraWords{"scripted, at another socket", "is on USB 2"}));
  EXPECT_EQ(count(once.log, "camera scripted, at another socket\n"), 1u) << once.log;
  EXPECT_EQ(count(once.log, "the camera is on USB 2\n"), 1u) << once.log;
  EXPECT_EQ(play({frame, gone}).words, (CameraWords{"scripted", ""})) << "it is not back";
  const Played twice = play({frame, gone, frame, gone, frame});
  EXPECT_EQ(twice.words, (CameraWords{"scripted", ""}));
  EXPECT_THAT(twice.log, HasSubstr("nothing limits the camera any more"));
  EXPECT_THAT(play({frame, frame}).log, testing::Not(HasSubstr("scripted"))) << "nothing is new";
}

TEST(Capture, TimeoutsAndBadFramesDoNotEndTheStream) {
  using enum Grab;
  const Played played = play({timeout, bad, frame, timeout, bad, frame});
  EXPECT_THAT(played.frames, testing::ElementsAre(0u, 1u));
  EXPECT_EQ(played.counters.bad, 2u);
  EXPECT_EQ(played.counters.gone, 0u);
  EXPECT_THAT(played.log, HasSubstr("frame refused: /dev/camera: torn"));
  EXPECT_THAT(played.log, testing::Not(HasSubstr("gone")));
}

// Also those of a camera that has counted before the first frame, and of what happened after the last one.
TEST(Capture, WhatTheCameraCountsIsTakenFromIt) {
  using enum Grab;
  EXPECT_EQ(play({}).counters.unmatched, 1u);
  const Played played = play({frame, bad, timeout, frame, bad, timeout, timeout});
  EXPECT_EQ(played.counters.unmatched, 3u);
  EXPECT_EQ(played.counters.missed, 6u);
}

// A driver that does not come back.
class StuckCamera final : public hal::DepthCamera {
 public:
  const hal::Intrinsics& intrinsics() const override { return intrinsics_; }
  Grab grab(hal::Frame&, std::chrono::milliseconds) override {
    entered.release();
    let_go.acquire();
    return Grab::end;
  }
  const Error& last_error() const override { return error_; }
  hal::CameraCounters counters() const override { return {}; }
  bool live() const override { return true; }
  std::uint64_t frames_expected() const override { return 0; }
  std::string description() const override { return "stuck"; }
  std::binary_semaphore entered{0}, let_go{0};

 private:
  hal::Intrinsics intrinsics_;
  Error error_;
};

TEST(Capture, ADriverThatDoesNotComeBackIsNoticed) {
  StuckCamera camera;
  Failures failures;
  Log log("robot");
  Capture capture(camera, {true, 1}, failures, log);
  EXPECT_FALSE(capture.heartbeat().stuck(now() + std::chrono::hours(1))) << "not begun";
  capture.start();
  camera.entered.acquire();
  EXPECT_FALSE(capture.heartbeat().stuck(now())) << "a while is allowed";
  EXPECT_TRUE(capture.heartbeat().stuck(now() + std::chrono::minutes(1)));
  camera.let_go.release();
  capture.stop();
  EXPECT_FALSE(capture.heartbeat().stuck(now() + std::chrono::hours(1))) << "it has ended";
}

TEST(Capture, FramesWhoseTimeDoesNotIncreaseAndFrozenOnesGoNoFurther) {
  const auto address = hal::parse_camera_address(
      "simulated:office?width=64&height=48&frames=60&freeze_at=10&time_back_at=40&fault_for=15");
  auto camera = hal::open_simulated(*address);
  ASSERT_TRUE(camera);
  Failures failures;
  Log log("robot");
  std::vector<std::uint64_t> seen, frames;
  testing::internal::CaptureStderr();
  Capture capture(**camera, {true, 1}, failures, log);
  capture.listen([&](const hal::FrameView& frame) { seen.push_back(frame.index); });
  capture.start();
  while (auto frame = capture.frames().pop()) frames.push_back(frame->index);
  capture.stop();
  const std::string said = testing::internal::GetCapturedStderr();
  std::vector<std::uint64_t> expected;
  for (std::uint64_t i = 0; i < 60; ++i)
    if (!(i >= 19 && i < 25) && !(i >= 40 && i < 50)) expected.push_back(i);
  EXPECT_EQ(frames, expected);
  EXPECT_EQ(seen, expected) << "the listener sees what goes on";
  EXPECT_EQ(capture.counters().grabbed, 60u);
  EXPECT_EQ(capture.counters().frozen, 15u);
  EXPECT_EQ(capture.counters().time_back, 10u);
  EXPECT_THAT(said, HasSubstr("robot: frame 19: the camera shows the same picture again and again"));
  EXPECT_THAT(said, HasSubstr("robot: frame 40 refused: its time, 1599996401.333 s, is not after the one before it"));
  EXPECT_THAT(said, HasSubstr("its times are moved by 3599.667 s"));
}

}  // namespace
}  // namespace onemap::daemon
