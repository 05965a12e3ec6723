// What is recorded is what replay plays; and a recording never holds anybody up.
#include "daemon/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <memory>

#include "daemon/cameras.hpp"
#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;

constexpr const char* kWalk = "simulated:living-room?frames=12&seed=5&width=160&height=120";

std::unique_ptr<hal::DepthCamera> open(const std::string& address) {
  auto camera = hal::open_camera(camera_backends(), address);
  if (!camera) throw std::runtime_error(camera.error().text());
  return std::move(*camera);
}

struct Taken {
  FrameTime colour{}, depth{};
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> values;
  bool operator==(const Taken&) const = default;
};

// Every frame of a camera; what could not be read is the test's failure.
std::vector<Taken> frames_of(hal::DepthCamera& camera, const std::function<void(const hal::FrameView&)>& each = {}) {
  hal::FramePool pool(camera.intrinsics(), 1);
  std::vector<Taken> taken;
  for (;;) {
    hal::Frame frame = pool.acquire();
    const hal::Grab grab = camera.grab(frame, std::chrono::seconds(1));
    if (grab == hal::Grab::end) return taken;
    EXPECT_EQ(grab, hal::Grab::frame) << camera.last_error().text();
    if (each) each(frame.view());
    const hal::FrameView view = frame.view();
    taken.push_back({view.colour_time,
                     view.depth_time,
                     {view.rgb.begin(), view.rgb.end()},
                     {view.depth.begin(), view.depth.end()}});
  }
}

RecorderConfig every_frame() {
  RecorderConfig config;
  config.every_frame = true;
  config.least_free_bytes = 0;
  return config;
}

TEST(Recorder, ARecordedWalkPlaysAsItWas) {
  const TempFolder folder;
  Log log("robot");
  for (const std::string options : {"", "&depth_late_ms=7", "&noise=none"}) {
    const std::string place = folder / ("walk" + options);
    auto camera = open(kWalk + options);
    Recorder recorder(every_frame(), recorded(*camera), truth_of(kWalk + options), log);
    ASSERT_TRUE(recorder.start(place));
    const auto walked = frames_of(*camera, [&](const hal::FrameView& frame) { recorder.offer(frame); });
    const RecorderView view = recorder.stop();
    EXPECT_FALSE(view.recording);
    EXPECT_EQ(view.frames, 12u);
    EXPECT_EQ(view.dropped, 0u);
    EXPECT_EQ(view.ended, "");
    auto played = open("replay:" + place);
    EXPECT_EQ(played->intrinsics(), camera->intrinsics());
    EXPECT_EQ(frames_of(*played), walked) << options;
    EXPECT_EQ(played->counters().unmatched, 0u);
    EXPECT_EQ(test::lines_of(place + "/groundtruth.txt").size(), 1u + 12u);
    EXPECT_THAT(test::text_of(place + "/groundtruth.txt"), HasSubstr("\n1600000000.366666666 "));
  }
}

TEST(Recorder, DepthOfAnotherScaleIsWrittenInTheLayoutsOwn) {
  const TempFolder folder;
  hal::Intrinsics k;
  k.width = 4, k.height = 1, k.depth_scale = 1000;
  k.fx = k.fy = 4, k.cx = 1.5, k.cy = 0;
  hal::FramePool pool(k, 1);
  hal::Frame frame = pool.acquire();
  std::ranges::fill(frame.rgb(), std::uint8_t{9});
  const std::uint16_t values[] = {0, 1, 13107, 13108};  // the last is farther than the file can say
  std::ranges::copy(values, frame.depth().begin());
  const hal::DepthNoise noise{0.002, 0.01 / 3, 0.25};
  auto writer = RecordingWriter::open(folder / "r", {k, noise, "four pixels"});
  ASSERT_TRUE(writer) << writer.error().text();
  ASSERT_TRUE(writer->write(frame.view()));
  const auto replay = open("replay:" + folder / "r");
  EXPECT_EQ(replay->depth_noise(), noise) << "to the last bit: the map is the same again";
  const auto played = frames_of(*replay);
  ASSERT_EQ(played.size(), 1u);
  EXPECT_THAT(played[0].values, testing::ElementsAre(0, 5, 65535, 0));
}

TEST(Recorder, NothingIsWrittenOverAndOneRecordingRunsAtATime) {
  const TempFolder folder;
  auto camera = open(kWalk);
  Log log("robot");
  Recorder recorder(every_frame(), recorded(*camera), {}, log);
  ASSERT_TRUE(recorder.start(folder / "a"));
  EXPECT_TRUE(recorder.view().recording);
  EXPECT_THAT(recorder.start(folder / "b").error().text(), HasSubstr("is running, in " + folder / "a"));
  recorder.stop();
  EXPECT_THAT(recorder.start(folder / "a").error().text(), HasSubstr("holds a recording already"));
  folder.write("file", "x");
  EXPECT_THAT(recorder.start(folder / "file").error().text(), HasSubstr("cannot make the folder"));
  EXPECT_TRUE(recorder.start(folder / "b")) << "after all that";
  EXPECT_EQ(recorder.stop().frames, 0u);
  EXPECT_EQ(recorder.stop().folder, folder / "b") << "once more does nothing";
}

TEST(Recorder, ALimitEndsItAndSaysSo) {
  const TempFolder folder;
  auto camera = open(kWalk);
  Log log("robot");
  RecorderConfig config = every_frame();
  config.limit_bytes = 100'000;  // two frames or three
  testing::internal::CaptureStderr();
  Recorder recorder(config, recorded(*camera), {}, log);
  ASSERT_TRUE(recorder.start(folder / "r"));
  frames_of(*camera, [&](const hal::FrameView& frame) { recorder.offer(frame); });
  const RecorderView view = recorder.stop();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(view.ended, HasSubstr("record.limit_mb"));
  EXPECT_GE(view.frames, 1u);
  EXPECT_LT(view.frames, 12u);
  EXPECT_THAT(said, HasSubstr("the recording ended after"));
  EXPECT_EQ(frames_of(*open("replay:" + folder / "r")).size(), view.frames);

  config = every_frame();
  config.least_free_bytes = std::uint64_t{1} << 60;
  Recorder greedy(config, recorded(*camera), {}, log);
  EXPECT_THAT(greedy.start(folder / "s").error().text(), HasSubstr("fewer than record.least_free_mb"));
}

TEST(Recorder, ADiskThatTakesNoMoreEndsItAndTheRestPlays) {
  const TempFolder folder;
  auto camera = open(kWalk);
  Log log("robot");
  Recorder recorder(every_frame(), recorded(*camera), {}, log);
  ASSERT_TRUE(recorder.start(folder / "r"));
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  int offered = 0;
  testing::internal::CaptureStderr();
  frames_of(*camera, [&](const hal::FrameView& frame) {
    recorder.offer(frame);
    if (++offered != 5) return;
    while (recorder.view().frames < 5) usleep(1000);
    const rlimit small{1000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  });
  const RecorderView view = recorder.stop();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(view.frames, 5u);
  EXPECT_THAT(view.ended, HasSubstr("cannot write: File too large"));
  EXPECT_EQ(frames_of(*open("replay:" + folder / "r")).size(), 5u);
}

TEST(Recorder, FramesThatDoNotFitAreDroppedCountedAndSaid) {
  const TempFolder folder;
  auto camera = open(kWalk);
  Log log("robot");
  RecorderConfig config;
  config.least_free_bytes = 0;
  // Whoever asks for the truth holds up the recorder, as a slow disk would.
  std::mutex slow;
  const TruthLine truth = [&](const hal::FrameView&) {
    const std::lock_guard lock(slow);
    return std::optional<std::string>("0 0 0 0 0 0 1");
  };
  Recorder recorder(config, recorded(*camera), truth, log);
  ASSERT_TRUE(recorder.start(folder / "r"));
  testing::internal::CaptureStderr();
  {
    const std::lock_guard lock(slow);
    frames_of(*camera, [&](const hal::FrameView& frame) { recorder.offer(frame); });
  }
  const RecorderView view = recorder.stop();
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("recording is slower than the camera: 1 frames of it dropped"));
  EXPECT_EQ(view.dropped, 12u - Recorder::kQueued);
  EXPECT_EQ(view.frames, Recorder::kQueued);
  EXPECT_EQ(frames_of(*open("replay:" + folder / "r")).size(), Recorder::kQueued);
}

TEST(Recorder, BothFormatsAreWrittenBesideEachOther) {
  const TempFolder folder;
  auto camera = open(kWalk);
  Log log("robot");
  RecorderConfig config = every_frame();
  config.mcap = true;
  Recorder recorder(config, recorded(*camera), {}, log);
  ASSERT_TRUE(recorder.start(folder / "both"));
  frames_of(*camera, [&](const hal::FrameView& frame) {
    recorder.offer(frame);
    recorder.pose({frame.colour_time, {}, std::nullopt});
  });
  EXPECT_EQ(recorder.stop().frames, 12u);
  EXPECT_EQ(frames_of(*open("replay:" + folder / "both")).size(), 12u);
  const std::string mcap = test::text_of(folder / "both/recording.mcap");
  EXPECT_TRUE(mcap.ends_with("\x89MCAP0\r\n")) << "finished";
  EXPECT_THAT(mcap, HasSubstr("/pose/odom")) << "in the summary";

  config.tum = false;
  Recorder only(config, recorded(*camera), {}, log);
  ASSERT_TRUE(only.start(folder / "mcap"));
  only.stop();
  EXPECT_FALSE(std::filesystem::exists(folder / "mcap/rgb.txt"));
  EXPECT_FALSE(only.start(folder / "mcap")) << "nothing is written over";
}

// A process that is killed in the middle: what it leaves plays, without a frame that cannot be read.
TEST(Recorder, WhatAKilledProcessLeavesPlays) {
  const TempFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    auto camera = open("simulated:living-room?frames=100000&seed=5&width=160&height=120");
    auto writer = RecordingWriter::open(folder / "r", recorded(*camera));
    hal::FramePool pool(camera->intrinsics(), 1);
    hal::Frame frame = pool.acquire();
    while (writer && camera->grab(frame, std::chrono::seconds(1)) == hal::Grab::frame && writer->write(frame.view())) {
    }
    _exit(1);
  }
  const std::string list = folder / "r/rgb.txt";
  for (int i = 0; i < 3000 && (!std::filesystem::exists(list) || test::lines_of(list).size() < 20); ++i) usleep(10000);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const auto played = frames_of(*open("replay:" + folder / "r"));
  EXPECT_GE(played.size(), 18u);
  EXPECT_GE(played.size() + 1, test::lines_of(folder / "r/rgb.txt").size() - 2);
}

}  // namespace
}  // namespace onemap::daemon
