// One real onemapd on simulated and recorded cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "support/program.hpp"
#include "support/running.hpp"
#include "support/trajectory.hpp"

namespace onemap {
namespace {

using test::TempFolder;
using testing::HasSubstr;

constexpr const char* kCamera = "simulated:living-room?robot=1&robots=3&frames=60&seed=3";

bool starts_with(const std::filesystem::path& file, const std::string& magic) {
  return test::text_of(file).substr(0, magic.size()) == magic;
}

void expect_local_outputs(const std::filesystem::path& out) {
  EXPECT_TRUE(starts_with(out / "local.png", "\x89PNG\r\n"));
  EXPECT_TRUE(starts_with(out / "local.glb", "glTF"));
  EXPECT_TRUE(starts_with(out / "local.ply", "ply\nformat binary_little_endian"));
  EXPECT_TRUE(starts_with(out / "local.pcd", "# .PCD v0.7"));
  for (const char* name : {"local.png", "local.glb", "local.ply", "local.pcd"})
    EXPECT_GT(std::filesystem::file_size(out / name), 10000u) << name;
}

TEST(Once, WritesTrajectoryPicturesAndReport) {
  const TempFolder out;
  ASSERT_EQ(test::run("onemapd", {"--camera", kCamera, "--once", "--speed", "max", "--out", out.path().string()},
                      out / "log.txt"),
            0)
      << test::text_of(out / "log.txt");
  expect_local_outputs(out / "");
  const auto report = test::read_json(out / "report.json");
  const auto& robot = report.at("robots").at(0);
  EXPECT_EQ(robot.at("camera"), kCamera);
  EXPECT_EQ(robot.at("frames"), 60);
  EXPECT_GE(robot.at("tracked").get<int>(), 57);
  EXPECT_EQ(robot.at("tracked").get<std::size_t>(), test::lines(out / "trajectory.txt"));
  EXPECT_EQ(report.at("reference"), robot.at("name"));
  EXPECT_GT(report.at("global_points").get<int>(), 1000);
  EXPECT_GT(robot.at("ms_per_frame").at("p50").get<double>(), 0);
  EXPECT_FALSE(std::filesystem::exists(out / "global.png")) << "a robot alone has no team";
  EXPECT_EQ(test::lines(out / ("global/" + robot.at("name").get<std::string>() + ".txt")),
            robot.at("tracked").get<std::size_t>())
      << "and yet its way bends at the places that it came back to";
  EXPECT_TRUE(starts_with(out / "map.pgm", "P5\n"));
  EXPECT_THAT(test::text_of(out / "map.yaml"), HasSubstr("image: map.pgm\nresolution: 0.050000\norigin: ["));
  EXPECT_THAT(test::text_of(out / "graph.g2o"), HasSubstr("VERTEX_SE3:QUAT "));
  EXPECT_GT(robot.at("plan_squares").get<int>(), 1000);
  EXPECT_EQ(robot.at("plan_votes_refused"), 0);
}

TEST(Once, TheSameStreamGivesTheSameBytes) {
  const TempFolder out;
  for (const char* run : {"a", "b"})
    ASSERT_EQ(
        test::run("onemapd", {"--camera", kCamera, "--once", "--speed", "max", "--out", out / run}, out / "log.txt"),
        0);
  EXPECT_EQ(test::text_of(out / "a/trajectory.txt"), test::text_of(out / "b/trajectory.txt"));
  for (const char* name : {"local.ply", "local.pcd", "map.pgm", "map.yaml"})
    EXPECT_EQ(test::text_of(out.path() / "a" / name), test::text_of(out.path() / "b" / name)) << name;
  EXPECT_EQ(test::read_json(out / "a/report.json").at("robots").at(0).at("map_digest"),
            test::read_json(out / "b/report.json").at("robots").at(0).at("map_digest"));
}

// Two seconds where it has the machine for itself; here other tests have it, too.
TEST(Once, SigtermStopsSoonAndWritesWhatThereIs) {
  const TempFolder out;
  const std::string camera = "simulated:living-room?width=320&height=240&robot=1&robots=3&frames=100000&seed=3";
  auto daemon = test::start("onemapd", {"--camera", camera, "--once", "--out", out.path().string()}, out / "log.txt");
  for (int i = 0; i < 600; ++i) {  // until it has a little map
    const auto status = nlohmann::json::parse(test::text_of(out / "status.json"), nullptr, false);
    if (!status.is_discarded() && status.at("tracked").get<int>() >= 20) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_TRUE(daemon.running()) << test::text_of(out / "log.txt");
  daemon.terminate();
  ASSERT_TRUE(daemon.wait(test::kPatience * std::chrono::seconds(20))) << test::text_of(out / "log.txt");
  EXPECT_EQ(daemon.exit_code(), 3) << "the stream was not over";
  EXPECT_GE(test::lines(out / "trajectory.txt"), 15u);
  expect_local_outputs(out / "");
  EXPECT_EQ(test::read_json(out / "report.json").at("robots").size(), 1u);
}

TEST(Once, RecordedCutIsTrackedAlongTheTruth) {
  const std::filesystem::path recording = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/fr1_xyz";
  if (!std::filesystem::exists(recording)) GTEST_SKIP() << "the recording " << recording << " is not here";
  const TempFolder out;
  ASSERT_EQ(test::run("onemapd",
                      {"--camera", "replay:" + recording.string() + ":0:120", "--once", "--speed", "max",
                       "--matches-picture", "50", "--out", out.path().string()},
                      out / "log.txt"),
            0)
      << test::text_of(out / "log.txt");
  EXPECT_GE(test::lines(out / "trajectory.txt"), 118u);
  std::string drawn;  // frame 50 against an earlier keyframe
  for (const auto& entry : std::filesystem::directory_iterator(out / "matches"))
    if (entry.path().filename().string().ends_with("-000050.png")) drawn = entry.path().string();
  ASSERT_FALSE(drawn.empty());
  EXPECT_TRUE(starts_with(drawn, "\x89PNG\r\n"));
  // Every time is a colour time of the recording, as it stands there.
  const std::string colour = test::text_of(recording / "rgb.txt");
  std::istringstream poses(test::text_of(out / "trajectory.txt"));
  for (std::string line; std::getline(poses, line);) EXPECT_THAT(colour, HasSubstr(line.substr(0, line.find(' '))));
}

}  // namespace
}  // namespace onemap
