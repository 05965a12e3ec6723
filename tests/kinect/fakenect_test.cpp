// The Kinect backend on fakenect, libfreenect's own stand-in, which plays what a Kinect would have sent.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifdef ONEMAP_FAKENECT_DIR
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <functional>

#include "hal/backends/libusb.hpp"
#include "hal/imaging/raw_depth.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/kinect_session.hpp"
#include "support/temp_folder.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const std::string kRoom = "simulated:office?seed=4";

// fakenect is one Kinect a process, with one session: each test has a process of its own.
void in_a_child(const std::string& session, const std::function<void()>& test) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    setenv("FAKENECT_PATH", session.c_str(), 1);
    test();
    std::fflush(nullptr);
    _exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "see the failures of the child above";
}

std::unique_ptr<DepthCamera> open(const std::string& text, Duration clock_offset = {}) {
  auto address = parse_camera_address(text);
  address->clock_offset = clock_offset;
  auto camera = open_libusb(*address);
  EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().text());
  return camera.ok() ? std::move(*camera) : nullptr;
}

Grab grab_past_timeouts(DepthCamera& camera, Frame& frame) {
  Grab grab = Grab::timeout;
  for (int tries = 0; grab == Grab::timeout && tries < 400; ++tries) grab = camera.grab(frame, 50ms);
  return grab;
}

// The room's pictures again, as the session was written from them.
class Room {
 public:
  Room() : camera_(std::move(open_simulated(*parse_camera_address(kRoom))).value()), pool_(camera_->intrinsics(), 1) {
    frame_ = pool_.acquire();
  }
  ~Room() { frame_ = Frame(); }
  const Frame& at(std::uint64_t index) {
    while (!any_ || frame_.index < index) {
      EXPECT_EQ(camera_->grab(frame_, 0ms), Grab::frame);
      any_ = true;
    }
    return frame_;
  }

 private:
  std::unique_ptr<DepthCamera> camera_;
  FramePool pool_;
  Frame frame_;
  bool any_ = false;
};

TEST(Fakenect, ARoomArrivesPixelForPixelAndThenTheKinectIsGone) {
  const test::TempFolder session;
  constexpr int kFrames = 8;
  constexpr std::uint32_t kStart = 0xffff'ffff - 5'000'000;  // the counter starts again on the way
  test::write_kinect_session(session.path(), kRoom, kFrames, 6, kStart, 300'000);
  in_a_child(session.path(), [&] {
    const auto camera = open("libusb:?registration=none", 1000s);
    ASSERT_TRUE(camera);
    EXPECT_TRUE(camera->live());
    EXPECT_EQ(camera->intrinsics(), Intrinsics({.depth_scale = 1000}));
    EXPECT_THAT(camera->description(), HasSubstr("Kinect v1"));
    FramePool pool(camera->intrinsics(), 1);
    Frame frame = pool.acquire();
    Room room;
    std::uint64_t seen = 0;
    std::pair<std::uint64_t, FrameTime> first;  // a busy machine may miss the very first
    Grab grab = grab_past_timeouts(*camera, frame);
    for (; grab == Grab::frame; grab = grab_past_timeouts(*camera, frame)) {
      const Frame& truth = room.at(frame.index);
      EXPECT_TRUE(std::ranges::equal(frame.rgb(), truth.rgb())) << frame.index;
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < truth.depth().size(); ++i)
        wrong += std::abs(frame.depth()[i] * 0.001 - truth.depth()[i] / 5000.0) > 0.0007;
      EXPECT_EQ(wrong, 0u) << frame.index;
      if (seen == 0) first = {frame.index, frame.colour_time};
      EXPECT_GE(to_seconds(frame.colour_time), 1000);
      const double since_first = static_cast<double>(frame.index - first.first) / 30;
      EXPECT_NEAR(to_seconds(frame.colour_time - first.second), since_first, 1e-6);
      EXPECT_EQ(frame.depth_time - frame.colour_time, Duration(5ms));
      ++seen;
    }
    EXPECT_EQ(grab, Grab::gone);
    EXPECT_THAT(camera->last_error().text(), HasSubstr("disconnected"));
    EXPECT_EQ(camera->counters().frames, seen);
    EXPECT_EQ(seen + camera->counters().missed, static_cast<std::uint64_t>(kFrames));
    EXPECT_GE(seen, 2u) << "a busy machine may miss some";
    EXPECT_EQ(camera->grab(frame, 10ms), Grab::gone);
  });
}

TEST(Fakenect, WithoutRegisteredDepthItIsOurs) {
  const test::TempFolder session;
  test::write_kinect_session(session.path(), kRoom, 3, 6);
  in_a_child(session.path(), [&] {
    const auto refused = open_libusb(*parse_camera_address("libusb:?registration=device"));
    ASSERT_FALSE(refused.ok());
    EXPECT_THAT(refused.error().text(), HasSubstr("no registered depth"));
  });
  in_a_child(session.path(), [&] {
    const auto camera = open("libusb:");
    ASSERT_TRUE(camera);
    EXPECT_THAT(camera->description(), HasSubstr("registered by us"));
    FramePool pool(camera->intrinsics(), 1);
    Frame frame = pool.acquire();
    ASSERT_EQ(grab_past_timeouts(*camera, frame), Grab::frame);
    // On the optical axis a depth camera 25 mm to the left sees at 319.5 what is 25 mm left of the colour camera's
    // axis.
    Room room;
    const Frame& truth = room.at(frame.index);
    std::size_t compared = 0, same = 0;
    for (int y = 200; y < 280; ++y) {
      for (int x = 200; x < 440; ++x) {
        const std::uint16_t seen = truth.depth()[static_cast<std::size_t>(y * 640 + x)];
        if (seen == 0) continue;
        const double z = seen / 5000.0;
        const auto u = static_cast<int>(std::lround(525 * ((x - 319.5) / 580 - 0.025 / z) + 319.5));
        const auto v = static_cast<int>(std::lround(525 * (y - 239.5) / 580 + 239.5));
        ++compared;
        same += std::abs(frame.depth()[static_cast<std::size_t>(v * 640 + u)] * 0.001 - z) < 0.02 * z;
      }
    }
    EXPECT_GT(static_cast<double>(same), 0.95 * static_cast<double>(compared));
  });
}

struct Walk {
  std::map<std::uint64_t, mapping::Vector3d> positions;
  std::uint64_t frames = 0;
};

// Maps the frames that the other camera delivered, or all.
Walk map(DepthCamera& camera, const Walk* like) {
  mapping::LocalMapperConfig config;
  config.max_keyframes = 40;
  mapping::LocalMapper mapper(config, camera.intrinsics(), camera.depth_noise());
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  Walk walk;
  for (Grab grab = Grab::frame; grab == Grab::frame;) {
    grab = grab_past_timeouts(camera, frame);
    if (grab != Grab::frame || (like && !like->positions.contains(frame.index))) continue;
    ++walk.frames;
    const auto report = mapper.process(frame.view());
    if (report.state == mapping::TrackState::tracking) walk.positions[frame.index] = report.T_robot_camera.t;
  }
  return walk;
}

TEST(Fakenect, ARoomIsMappedAsThroughTheSimulatedCamera) {
  const test::TempFolder session;
  constexpr int kFrames = 30;
  test::write_kinect_session(session.path(), kRoom, kFrames, 4);
  in_a_child(session.path(), [&] {
    const auto camera = open("libusb:?registration=none");
    ASSERT_TRUE(camera);
    const Walk walk = map(*camera, nullptr);
    EXPECT_EQ(walk.positions.size(), walk.frames) << "all were tracked";
    EXPECT_GE(walk.frames, std::string(ONEMAP_SANITIZE).empty() ? 15u : 6u) << "a busy machine may miss some";
    const auto simulated =
        std::move(open_simulated(*parse_camera_address(kRoom + "&frames=" + std::to_string(kFrames)))).value();
    const Walk truth = map(*simulated, &walk);
    ASSERT_EQ(truth.positions.size(), walk.positions.size());
    double squares = 0;
    for (const auto& [index, position] : truth.positions)
      squares += (walk.positions.at(index) - position).squaredNorm();
    EXPECT_LT(std::sqrt(squares / static_cast<double>(truth.positions.size())), 0.002);
  });
}

}  // namespace
}  // namespace onemap::hal
#else
TEST(Fakenect, IsNotHere) {
  GTEST_SKIP() << "libfreenect-dev with its fakenect library is not installed: the Kinect backend was not tested";
}
#endif
