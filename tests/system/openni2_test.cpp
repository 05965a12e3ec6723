// A simulated room, seen through the real OpenNI2 library: our test driver streams it, our backend takes it.
#ifdef ONEMAP_OPENNI2_DIR
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <sstream>

#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/openni2_devices.hpp"
#include "support/running.hpp"
#include "support/trajectory.hpp"

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

// The trajectory's positions by the number of the frame, counted from the first that was tracked.
void number_frames(const std::filesystem::path& trajectory, const std::filesystem::path& into) {
  std::ostringstream out;
  std::optional<double> first;
  for (const std::string& line : test::lines_of(trajectory)) {
    double time = 0, x = 0, y = 0, z = 0;
    if (line.starts_with('#') || !(std::istringstream(line) >> time >> x >> y >> z)) continue;
    if (!first) first = time;
    out << std::lround((time - *first) * 30) << " " << x << " " << y << " " << z << " 0 0 0 1\n";
  }
  ASSERT_TRUE(write_text_file(into.string(), out.str()).ok());
}

double best_error_m(const test::TempFolder& folder, const std::string& room) {
  const auto truth = hal::simulated_truth(*hal::parse_camera_address(room));
  double best = 1e9;
  for (std::size_t first = 0; first < truth->size(); ++first) {  // frames before the tracker was ready
    std::ostringstream out;
    for (std::size_t i = first; i < truth->size(); ++i) {
      const auto& t = (*truth)[i].t_world_camera_m;
      out << i - first << " " << t[0] << " " << t[1] << " " << t[2] << " 0 0 0 1\n";
    }
    folder.write("truth.txt", out.str());
    const double error = test::team_ate({{folder / "numbered.txt", folder / "truth.txt"}});
    if (error < best) best = error;
  }
  return best;
}

TEST(OpenNi2, TheDaemonMapsADeviceAndWaitsForItWhileItIsGone) {
  const test::TempFolder folder;
  test::OpenNi2Devices devices;
  const std::string room = "simulated:living-room?robot=1&robots=3&seed=3&width=320&height=240&frames=1000";
  const std::string lines = "room " + room + "\nhz 15\nclock_restarts 0\n";
  setenv("LD_LIBRARY_PATH", ONEMAP_OPENNI2_DIR, 1);
  // OpenNI2's drivers leak when they are unloaded, and then have no name by which a report could leave them out.
  setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  devices.plug("a", lines);
  test::Robot robot(folder, "r", "auto", {});
  unsetenv("LD_LIBRARY_PATH");
  unsetenv("ASAN_OPTIONS");
  const auto tracked = [&](int more) {
    const int now = robot.status("tracked", 0);
    return test::wait_until([&] { return robot.status("tracked", 0) >= now + more; }, 120s);
  };
  ASSERT_TRUE(robot.says("room://a")) << robot.log();
  ASSERT_TRUE(tracked(40)) << robot.log();
  devices.unplug("a");
  ASSERT_TRUE(robot.says("the camera is gone", 60s)) << robot.log();
  devices.plug("a", lines);
  ASSERT_TRUE(robot.says("the camera is back", 60s)) << robot.log();
  ASSERT_TRUE(tracked(40)) << robot.log();
  EXPECT_EQ(robot.stop(), 0) << robot.log();
  number_frames(robot.out() / "trajectory.txt", folder / "numbered.txt");
  EXPECT_LT(best_error_m(folder, room), 0.03);
  EXPECT_THAT(robot.log(), HasSubstr("the camera went away 1 times"));
}

}  // namespace
}  // namespace onemap
#endif
