#include "daemon/status.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/fleet/fleet.hpp"
#include "daemon/fleet/progress.hpp"
#include "daemon/latency.hpp"
#include "daemon/outputs.hpp"
#include "daemon/report.hpp"
#include "support/other_program.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

TEST(Status, SurvivesTheFile) {
  DaemonStatus status;
  status.state = "merging";
  status.frames = 12;
  status.frames_expected = 40;
  status.tracked = 11;
  status.keyframes = 3;
  status.frames_dropped = 4;
  status.frames_bad = 5;
  status.frames_missed = 6;
  status.images_unmatched = 7;
  status.map_digest = 0xFEDCBA9876543210u;
  status.frontier_digest = 0x00000000000000FFu;
  status.robots_known = 3;
  status.robots_finished = 2;
  status.agreed = true;
  status.map_agreed = true;
  status.map_differs = {"r3"};
  status.tracking = true;
  status.pose_time_s = 12.5;
  status.T_odom_camera.t = {1, 2, 3};
  status.T_map_odom = mapping::Pose{mapping::from_quaternion_wxyz({0.5, 0.5, 0.5, 0.5}), {0, 0, 1}};
  const test::TempFolder folder;
  const std::string file = folder / "status.json";
  ASSERT_TRUE(write_status(file, status).ok());
  const auto read = read_status(file);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(to_json(*read), to_json(status));
  EXPECT_EQ(read.value().map_digest, status.map_digest);
  EXPECT_EQ(read.value().frames_missed, 6u);
  EXPECT_EQ(read.value().images_unmatched, 7u);
  EXPECT_FALSE(read_status(folder / "none.json").ok());
}

TEST(Status, BrokenTextIsAnErrorWithItsPlace) {
  for (const char* text : {"", "{", "[]", "{\"state\": 3}", "{\"state\": \"tracking\"}"}) {
    const auto read = status_from_json(text, "here.json");
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().place, "here.json");
  }
}

RobotReport robot(const std::string& name, std::uint64_t digest) {
  RobotReport r;
  r.name = name;
  r.camera = "simulated:office";
  r.frames = 100;
  r.tracked = 99;
  r.keyframes = 7;
  r.in_global_map = true;
  r.map_digest = digest;
  r.ms_per_frame = {8.05, 12.1, 15.25};
  r.peak_rss_mb = 90.5;
  r.bytes_sent = 1000;
  r.bytes_received = 2000;
  r.plan_squares = 1200;
  r.plan_votes_refused = 3;
  return r;
}

TEST(Report, HasExactlyTheAgreedForm) {
  Report report{true, "robot1", 812, 34567, {robot("robot1", 0xABCu)}};
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json, nlohmann::json::parse(R"({"same_map": true, "reference": "robot1", "merge_ms": 812,
    "global_points": 34567, "robots": [{"name": "robot1", "camera": "simulated:office", "frames": 100, "tracked": 99,
    "keyframes": 7, "in_global_map": true, "map_digest": "0000000000000abc",
    "ms_per_frame": {"p50": 8.05, "p95": 12.1, "p99": 15.25}, "peak_rss_mb": 90.5, "bytes_sent": 1000,
    "bytes_received": 2000, "blocks_refused": 0, "plan_squares": 1200, "plan_votes_refused": 3,
    "refused": {}}]})"));
  const auto read = report_from_json(to_json(report), "");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(to_json(*read), to_json(report));
}

TEST(Report, TeamIsOnlyEqualWhenEverythingIs) {
  const Report a{true, "robot1", 100, 50, {robot("robot1", 7)}}, b{true, "robot1", 300, 50, {robot("robot2", 7)}};
  const Report team = join_reports({a, b}, true);
  EXPECT_TRUE(team.same_map);
  EXPECT_EQ(team.merge_ms, 300u);
  ASSERT_EQ(team.robots.size(), 2u);
  EXPECT_EQ(team.robots[1].name, "robot2");
  EXPECT_FALSE(join_reports({a, b}, false).same_map);
  Report other = b;
  other.robots[0].map_digest = 8;
  EXPECT_FALSE(join_reports({a, other}, true).same_map);
  other = b;
  other.reference = "robot2";
  EXPECT_FALSE(join_reports({a, other}, true).same_map);
  EXPECT_FALSE(join_reports({}, true).same_map);
}

TEST(Latency, QuantilesAreWithinABucketOfTheTruth) {
  LatencyHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(std::chrono::microseconds(20 * i));  // 0.02 .. 20 ms
  EXPECT_NEAR(histogram.quantile_ms(0.50), 10.0, 0.051);
  EXPECT_NEAR(histogram.quantile_ms(0.95), 19.0, 0.051);
  EXPECT_NEAR(histogram.quantile_ms(0.99), 19.8, 0.051);
  EXPECT_NEAR(histogram.total_ms(), 10010, 0.01);
  EXPECT_EQ(LatencyHistogram().quantile_ms(0.5), 0);
}

TEST(Trajectory, PrintsTheExactTimeAndTheComposedPose) {
  mapping::StampedPose pose;
  pose.time = frame_time_from_ns(1305031102175304000);
  pose.T_robot_camera = mapping::quantize({mapping::Matrix3d::Identity(), {1, 2, 3}});
  EXPECT_EQ(trajectory_text({pose}),
            "1305031102.175304 1.000000000 2.000000000 3.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n");
  mapping::Matrix3d half_turn = mapping::Matrix3d::Identity();  // about z
  half_turn(0, 0) = half_turn(1, 1) = -1;
  EXPECT_EQ(trajectory_text({pose}, {half_turn, {10, 0, 0}}).substr(0, 56),
            "1305031102.175304 9.000000000 -2.000000000 3.000000000 0");
}

std::vector<mapping::StampedPose> some_poses() {
  std::vector<mapping::StampedPose> poses;
  for (int i = 0; i < 20; ++i) {
    const Eigen::AngleAxisd turn(0.15 * i, Eigen::Vector3d(1, 2, -0.5).normalized());
    mapping::StampedPose& pose = poses.emplace_back();
    pose.time = frame_time_from_ns(1305031102175304000 + i * 33'333'000);
    pose.T_robot_camera = mapping::quantize({turn.toRotationMatrix(), {0.1 * i, -0.02 * i, 0.3}});
  }
  return poses;
}

// A reader's numbers after the word "read", eight a pose: time, place, quaternion x y z w.
void expect_read(const std::string& output, const std::vector<mapping::StampedPose>& poses, bool times) {
  const std::size_t at = output.find("read ");
  ASSERT_NE(at, std::string::npos) << output;
  std::istringstream words(output.substr(at + 5));
  for (const mapping::StampedPose& pose : poses) {
    double time = 0;
    mapping::Vector3d t;
    std::array<double, 4> q{};
    ASSERT_TRUE(words >> time >> t.x() >> t.y() >> t.z() >> q[1] >> q[2] >> q[3] >> q[0]) << output;
    const mapping::Pose should = mapping::from_quantized(pose.T_robot_camera);
    if (times) {
      EXPECT_NEAR(time, static_cast<double>(pose.time.time_since_epoch().count()) * 1e-9, 1e-6);
    }
    EXPECT_LT((t - should.t).norm(), 1e-6);
    EXPECT_LT((mapping::from_quaternion_wxyz(q) - should.R).norm(), 1e-6);
  }
  std::string more;
  EXPECT_FALSE(words >> more) << more;
}

TEST(Trajectory, Open3dReadsThePoses) {
  const std::string python = test::python_with("open3d");
  if (python.empty()) GTEST_SKIP() << "python3-open3d is not installed";
  const test::TempFolder folder;
  folder.write("trajectory.txt", trajectory_text(some_poses()));
  folder.write("say.py", R"(
import numpy, open3d, sys
print("read", end=" ")
for p in open3d.io.read_pinhole_camera_trajectory(sys.argv[1]).parameters:
    T = numpy.linalg.inv(p.extrinsic)  # it does not keep the time
    w = numpy.sqrt(1 + numpy.trace(T[:3, :3])) / 2
    print(0, *T[:3, 3], (T[2, 1] - T[1, 2]) / w / 4, (T[0, 2] - T[2, 0]) / w / 4, (T[1, 0] - T[0, 1]) / w / 4, w)
)");
  const auto said = test::say(python + " " + (folder / "say.py") + " " + (folder / "trajectory.txt"));
  ASSERT_EQ(said.status, 0) << said.output;
  expect_read(said.output, some_poses(), false);
}

TEST(Trajectory, EvoReadsTimesAndPoses) {
  const std::string python = test::python_with("evo.tools.file_interface");
  if (python.empty()) GTEST_SKIP() << "the Python module evo is not installed";
  const test::TempFolder folder;
  folder.write("trajectory.txt", trajectory_text(some_poses()));
  folder.write("say.py", R"(
import sys
from evo.tools import file_interface
t = file_interface.read_tum_trajectory_file(sys.argv[1])
assert t.check()[0], t.check()
print("read", end=" ")
for time, p, (w, x, y, z) in zip(t.timestamps, t.positions_xyz, t.orientations_quat_wxyz):
    print("%.6f" % time, *p, x, y, z, w)
)");
  const auto said = test::say(python + " " + (folder / "say.py") + " " + (folder / "trajectory.txt"));
  ASSERT_EQ(said.status, 0) << said.output;
  expect_read(said.output, some_poses(), true);
}

TEST(Progress, OneBarShowsTheShareOfAllAndTheTimeThatIsLeft) {
  DaemonStatus half, none;
  half.frames = 50;
  half.frames_expected = none.frames_expected = 100;
  const std::string early = Progress::bar({half, none}, std::chrono::seconds(1));
  EXPECT_EQ(early, "team     [" + std::string(10, '#') + std::string(30, '-') + "]  25 %  ");
  const std::string bar = Progress::bar({half, none}, std::chrono::seconds(30));
  EXPECT_NE(bar.find("  25 %  about 1 min 30 s left"), std::string::npos) << bar;
  half.frames = none.frames = 100;
  EXPECT_NE(Progress::bar({half, none}, std::chrono::seconds(30)).find("] 100 %  agreeing"), std::string::npos);
  EXPECT_NE(Progress::bar({{}}, std::chrono::seconds(30)).find("]   0 %"), std::string::npos);
}

TEST(Progress, LinesFitAHundredColumns) {
  DaemonStatus robot;
  robot.frames = robot.frames_expected = robot.tracked = 1000000;
  robot.keyframes = 99999;
  robot.state = "tracking";
  EXPECT_LE(Progress::line("robot64", robot).size(), Progress::kColumns);
  EXPECT_EQ(Progress::line("robot64", robot).find('\x1b'), std::string::npos);
  EXPECT_NE(Progress::line("robot64", robot, true).find("\x1b[33mtracking\x1b[0m"), std::string::npos);
  EXPECT_LE(Progress::bar({robot}, std::chrono::hours(100)).size(), Progress::kColumns);
  testing::internal::CaptureStderr();
  Progress(std::vector<std::string>(9, "robot64"), false, Instant{})
      .show(std::vector<DaemonStatus>(9, robot), Instant{});
  std::istringstream printed(testing::internal::GetCapturedStderr());
  int rows = 0;
  for (std::string row; std::getline(printed, row); ++rows) EXPECT_LE(row.size(), Progress::kColumns) << row;
  EXPECT_EQ(rows, 5);
}

}  // namespace
}  // namespace onemap::daemon
