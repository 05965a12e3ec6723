// A robot that goes round twice: where it thinks it was, and what the second round adds to its map.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mapping/team/way_on_map.hpp"
#include "support/returning_robot.hpp"
#include "support/stream.hpp"
#include "support/trajectory.hpp"

namespace onemap::mapping {
namespace {

struct Walk {
  double way_m = 0;
  double ate_m = 0, ate_of_odometry_m = 0;  // root mean square, of the whole way
  std::size_t blocks = 0;                   // of the map of all that it wrote
};

double ate(const std::vector<StampedPose>& way, const std::vector<hal::SimulatedPose>& truth) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> matched;
  auto at = truth.begin();
  for (const StampedPose& pose : way) {
    at = std::ranges::find(at, truth.end(), pose.time, &hal::SimulatedPose::time);
    if (at == truth.end()) throw std::runtime_error("a pose of a time at which the camera saw nothing");
    matched.emplace_back(from_quantized(pose.T_robot_camera).t, test::truth_pose(*at).t);
  }
  return test::aligned_rms(matched);
}

Walk go(const std::string& scene, std::size_t frames) {
  test::Stream stream(fmt::format("{}&frames={}&width=320&height=240", scene, frames));
  test::ReturningRobot robot(stream.intrinsics());
  std::size_t n = 0;
  while (const auto frame = stream.next()) {
    robot.see(frame->view());
    if (++n % 50 == 0) robot.work();
  }
  robot.finish();
  Walk out;
  for (std::size_t i = 1; i < stream.truth.size(); ++i)
    out.way_m += (test::truth_pose(stream.truth[i]).t - test::truth_pose(stream.truth[i - 1]).t).norm();
  TeamLog log(RobotId::from_name("b"), 1);
  for (const RecordPtr& record : robot.author.written()) EXPECT_TRUE(log.apply(record, {}).ok());
  out.blocks = test::fused(log, *robot.team.solution()).second;
  const TeamMember& member = *log.find(robot.author.id());
  SolvedRobot solved = robot.team.solution()->robots.at(0);
  const std::vector<StampedPose> way = way_on_map(member, solved);
  EXPECT_EQ(way.size(), frames) << "tracked throughout";
  out.ate_m = ate(way, stream.truth);
  solved.anchors.resize(1);
  out.ate_of_odometry_m = ate(way_on_map(member, solved), stream.truth);
  fmt::print("{}: {:.1f} m, ATE {:.4f} m ({:.2f} %), of the odometry {:.4f} m; {} blocks\n", scene, out.way_m,
             out.ate_m, 100 * out.ate_m / out.way_m, out.ate_of_odometry_m, out.blocks);
  return out;
}

TEST(TwiceRound, ALivingRoom) {
  const std::string scene = "simulated:living-room?fps=10";  // 21.2 s a round
  const Walk once = go(scene, 212), twice = go(scene, 424);
  EXPECT_LE(twice.ate_m, 0.003 * once.way_m);
  EXPECT_LT(twice.ate_m, twice.ate_of_odometry_m) << "what it knows again helps";
  EXPECT_LE(twice.blocks, once.blocks * 110 / 100);
}

TEST(TwiceRound, ACorridorThatLeadsIntoItself) {
  const std::string scene = "simulated:ring?fps=5";  // 100 s a round
  const Walk once = go(scene, 500), twice = go(scene, 1000);
  EXPECT_LE(twice.ate_m, 0.01 * once.way_m);
  EXPECT_LT(twice.ate_m, twice.ate_of_odometry_m) << "what it knows again helps";
  EXPECT_LE(twice.blocks, once.blocks * 110 / 100);
}

}  // namespace
}  // namespace onemap::mapping
