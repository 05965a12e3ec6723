// A simulated room, seen through the real OpenNI2 library: our test driver streams it, our backend takes it.
#ifdef ONEMAP_OPENNI2_DIR
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>
#include <thread>

#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/openni2_devices.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr std::uint64_t kFrames = 75;
const std::string kRoom = "simulated:living-room?robot=1&robots=3&seed=3&frames=" + std::to_string(kFrames);

std::unique_ptr<hal::DepthCamera> opened(Result<std::unique_ptr<hal::DepthCamera>> camera) {
  if (!camera) throw std::runtime_error(camera.error().text());
  return std::move(*camera);
}

// What LocalMapper makes of a camera: where it was at each frame, by the frame's number.
struct Walk {
  std::map<std::uint64_t, mapping::Vector3d> positions;
  mapping::LocalMapperCounters counters;
  std::uint64_t gone = 0;
};

// before(i) is called before frame i is waited for.
Walk map(hal::DepthCamera& camera, const std::function<void(std::uint64_t)>& before) {
  mapping::LocalMapperConfig config;
  config.max_keyframes = 40;
  mapping::LocalMapper mapper(config, camera.intrinsics());
  hal::FramePool pool(camera.intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  Walk walk;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    before(i);
    hal::Grab grab = hal::Grab::timeout;
    for (int tries = 0; grab != hal::Grab::frame && tries < 600; ++tries) {
      grab = camera.grab(frame, 50ms);
      walk.gone += grab == hal::Grab::gone;
    }
    if (grab != hal::Grab::frame) throw std::runtime_error("no frame " + std::to_string(i));
    const auto report = mapper.process(frame.view());
    if (report.state == mapping::TrackState::tracking) walk.positions[frame.index] = report.T_robot_camera.t;
  }
  walk.counters = mapper.counters();
  return walk;
}

Walk simulated() {
  const auto camera = opened(hal::open_simulated(*hal::parse_camera_address(kRoom)));
  return map(*camera, [](std::uint64_t) {});
}

// Root mean square distance of the two walks' positions.
double apart_m(const Walk& a, const Walk& b) {
  if (a.positions.size() != b.positions.size()) return 1e9;
  double squares = 0;
  for (const auto& [index, position] : a.positions) {
    const auto there = b.positions.find(index);
    squares += there == b.positions.end() ? 1e9 : (there->second - position).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(a.positions.size()));
}

TEST(OpenNi2, ARoomIsMappedAsThroughTheSimulatedCamera) {
  const Walk truth = simulated();
  for (const char* unit : {"0", "1"}) {
    test::OpenNi2Devices devices;
    devices.plug("a", "room " + kRoom + "\nsteps 1\nhundred_um " + unit + "\n");
    const auto camera = opened(hal::open_openni2(*hal::parse_camera_address("openni2:")));
    const Walk walk = map(*camera, [&](std::uint64_t) { devices.step("a"); });
    EXPECT_EQ(walk.counters.tracked, kFrames);
    EXPECT_LT(apart_m(walk, truth), 0.002) << "depth in 100 um: " << unit;
    RecordProperty(std::string("apart_um_") + unit, static_cast<int>(1e6 * apart_m(walk, truth)));
  }
}

TEST(OpenNi2, ADeviceThatIsPulledOutAndPluggedInGoesOnWithTheSameMap) {
  const Walk truth = simulated();
  test::OpenNi2Devices devices;
  const std::string lines = "room " + kRoom + "\nsteps 1\nhundred_um 1\n";
  devices.plug("a", lines);
  const auto camera = opened(hal::open_openni2(*hal::parse_camera_address("openni2:")));
  hal::FramePool pool(camera->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  const Walk walk = map(*camera, [&](std::uint64_t i) {
    if (i == kFrames / 2) {
      devices.unplug("a");
      hal::Grab grab = hal::Grab::timeout;
      for (int tries = 0; grab == hal::Grab::timeout && tries < 600; ++tries) grab = camera->grab(frame, 50ms);
      EXPECT_EQ(grab, hal::Grab::gone);
      devices.plug("a", lines);
    }
    devices.step("a");
  });
  EXPECT_EQ(walk.counters.tracked, kFrames);
  EXPECT_LT(apart_m(walk, truth), 0.005);
}

constexpr std::uint64_t kDaemonFrames = 150;
const std::string kDaemonRoom =
    "simulated:living-room?robot=1&robots=3&seed=3&width=320&height=240&frames=" + std::to_string(kDaemonFrames);

// A daemon's trajectory by the number of the frame: the first one is tracked, and the others' times count from it.
Walk walk_of(const std::filesystem::path& trajectory) {
  Walk walk;
  std::optional<double> first;
  for (const std::string& line : test::lines_of(trajectory)) {
    double time = 0;
    mapping::Vector3d p;
    if (line.starts_with('#') || !(std::istringstream(line) >> time >> p.x() >> p.y() >> p.z())) continue;
    if (!first) first = time;
    walk.positions[static_cast<std::uint64_t>(std::lround((time - *first) * 30))] = p;
  }
  return walk;
}

Walk simulated_by_daemon(const test::TempFolder& folder) {
  test::Robot robot(folder, "simulated", kDaemonRoom, {"--once", "--speed", "max"});
  EXPECT_EQ(robot.ends(120s), 0) << robot.log();
  return walk_of(robot.out() / "trajectory.txt");
}

// Of the frames that both have; how many one has and the other has not.
struct Compared {
  double apart_m = 0;
  std::size_t missing = 0;
};
Compared compared(const Walk& a, const Walk& b) {
  Walk common_a, common_b;
  for (const auto& [number, position] : a.positions)
    if (const auto there = b.positions.find(number); there != b.positions.end()) {
      common_a.positions[number] = position;
      common_b.positions[number] = there->second;
    }
  const std::size_t common = common_a.positions.size();
  return {common > 0 ? apart_m(common_a, common_b) : 1e9, a.positions.size() + b.positions.size() - 2 * common};
}

// A daemon whose camera is our device, in a library that was not built for its sanitizer.
std::unique_ptr<test::Robot> daemon_with_device(const test::TempFolder& folder) {
  setenv("LD_LIBRARY_PATH", ONEMAP_OPENNI2_DIR, 1);
  // OpenNI2's drivers leak when they are unloaded, and then have no name by which a report could leave them out.
  setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  auto robot = std::make_unique<test::Robot>(folder, "r", "auto", std::vector<std::string>{"--speed", "max"});
  unsetenv("LD_LIBRARY_PATH");
  unsetenv("ASAN_OPTIONS");
  return robot;
}

bool has_done(test::Robot& robot, std::uint64_t frames) {
  return test::wait_until([&] { return robot.status("frames", std::uint64_t{0}) >= frames; }, 120s);
}

const std::string kOnDemand = "room " + kDaemonRoom + "\non_demand 1\nhundred_um 1\nclock_restarts 0\n";

TEST(OpenNi2, TheDaemonMapsADeviceAsItMapsTheSimulatedCamera) {
  const test::TempFolder folder;
  const Walk truth = simulated_by_daemon(folder);
  ASSERT_GT(truth.positions.size(), kDaemonFrames - 5);
  test::OpenNi2Devices devices;
  devices.plug("a", kOnDemand);
  const auto robot = daemon_with_device(folder);
  ASSERT_TRUE(robot->says("room://a")) << robot->log();
  ASSERT_TRUE(has_done(*robot, kDaemonFrames)) << robot->log();
  EXPECT_EQ(robot->status("frames_missed", 99), 0);
  EXPECT_EQ(robot->status("images_unmatched", 99), 0);
  EXPECT_EQ(robot->stop(), 0) << robot->log();
  const Compared both = compared(walk_of(robot->out() / "trajectory.txt"), truth);
  EXPECT_EQ(both.missing, 0u);
  EXPECT_LT(both.apart_m, 0.002);
  RecordProperty("apart_um", static_cast<int>(1e6 * both.apart_m));
}

TEST(OpenNi2, TheDaemonWaitsForADeviceThatIsGoneAndGoesOnWithTheSameMap) {
  const test::TempFolder folder;
  const Walk truth = simulated_by_daemon(folder);
  test::OpenNi2Devices devices;
  devices.plug("a", kOnDemand);
  const auto robot = daemon_with_device(folder);
  ASSERT_TRUE(has_done(*robot, 40)) << robot->log();
  // With no picture on its way, so that both walks have the same frames: one that is lost moves the others by a
  // millimetre.
  devices.folder().write("a.paused", "");
  ASSERT_TRUE(test::wait_until(
      [&] {
        const auto frames = robot->status("frames", std::uint64_t{0});
        std::this_thread::sleep_for(600ms);
        return robot->status("frames", std::uint64_t{0}) == frames;
      },
      60s));
  devices.unplug("a");
  ASSERT_TRUE(robot->says("the camera is gone", 60s)) << robot->log();
  std::filesystem::remove(devices.folder() / "a.paused");
  devices.plug("a", kOnDemand);
  ASSERT_TRUE(robot->says("the camera is back", 60s)) << robot->log();
  ASSERT_TRUE(has_done(*robot, kDaemonFrames)) << robot->log();
  EXPECT_EQ(robot->stop(), 0) << robot->log();
  const Compared both = compared(walk_of(robot->out() / "trajectory.txt"), truth);
  EXPECT_EQ(both.missing, 0u);
  EXPECT_LT(both.apart_m, 0.002);
  RecordProperty("apart_um", static_cast<int>(1e6 * both.apart_m));
  EXPECT_THAT(robot->log(), HasSubstr("the camera went away 1 times"));
}

// Twelve images of a real PrimeSense camera that stands still, played by OpenNI2's own driver for files.
TEST(OpenNi2, TheDaemonMapsARealRecordingAndEndsWithIt) {
  const std::filesystem::path file = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/static_room.oni";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const test::TempFolder folder;
  setenv("LD_LIBRARY_PATH", ONEMAP_OPENNI2_DIR, 1);
  setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // as above
  test::Robot robot(folder, "r", "openni2:" + file.string(), {"--once", "--speed", "max"});
  unsetenv("LD_LIBRARY_PATH");
  unsetenv("ASAN_OPTIONS");
  ASSERT_EQ(robot.ends(120s), 0) << robot.log();
  EXPECT_THAT(robot.log(), HasSubstr("static_room.oni"));
  EXPECT_GE(robot.status("frames", 0), 11) << "the recording's first image may have no partner";
  EXPECT_EQ(robot.status("tracked", 0), robot.status("frames", -1)) << robot.log();
  const Walk walk = walk_of(robot.out() / "trajectory.txt");
  ASSERT_FALSE(walk.positions.empty());
  for (const auto& [frame, position] : walk.positions) EXPECT_LT(position.norm(), 0.01) << "it stands still: " << frame;
  EXPECT_THAT(robot.log(), HasSubstr("the map is "));
}

}  // namespace
}  // namespace onemap
#endif
