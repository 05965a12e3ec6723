// What the real programs say and exit with before and beside their work: versions, command lines, files and ports that
// cannot be had, names that are no text.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "comms/udp/udp_port.hpp"
#include "hal/imaging/encode_image.hpp"
#include "hal/imaging/rig_calibration.hpp"
#include "support/program.hpp"

namespace onemap {
namespace {

using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kShortWalk = "simulated:living-room?robot=1&robots=3&frames=20&seed=3";
constexpr const char* kUsage = "--help says what there is";

struct Ran {
  int status;
  std::string text;
};

Ran run(const TempFolder& folder, const std::string& program, const std::vector<std::string>& arguments) {
  const int status = test::run(program, arguments, folder / "program.txt");
  return {status, test::text_of(folder / "program.txt")};
}

// onemapd on a short stream, with more arguments.
Ran once(const TempFolder& folder, const std::vector<std::string>& more, const std::string& out = "out",
         const std::string& camera = kShortWalk) {
  std::vector<std::string> arguments{"--camera", camera, "--once", "--speed", "max", "--out", folder / out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run(folder, "onemapd", arguments);
}

TEST(Programs, EachSaysItsVersionAndHelp) {
  const TempFolder folder;
  for (const std::string program : {"onemapd", "onemap-fleet", "onemap-view", "onemap-eval", "onemap-calibrate"}) {
    const Ran version = run(folder, program, {"--version"});
    EXPECT_EQ(version.status, 0) << program;
    EXPECT_THAT(version.text, testing::MatchesRegex(program + " [0-9]+\\.[0-9]+\\.[0-9]+\n"));
    const Ran help = run(folder, program, {"--help"});
    EXPECT_EQ(help.status, 0) << program;
    EXPECT_THAT(help.text, AllOf(HasSubstr("--version"), HasSubstr("Exit status")));
    const Ran wrong = run(folder, program, {"--nonsense"});
    EXPECT_EQ(wrong.status, 2) << program;
    EXPECT_THAT(wrong.text, AllOf(testing::StartsWith(program + ": "), HasSubstr(kUsage)));
  }
}

TEST(Programs, HelpHasExamplesAndFitsATerminal) {
  const TempFolder folder;
  for (const std::string program :
       {"onemapd", "onemap-fleet", "onemap-view", "onemap-eval", "onemap-calibrate", "onemapctl"}) {
    const Ran help = run(folder, program, {"--help"});
    EXPECT_THAT(help.text, HasSubstr("Examples:\n  " + program + " "));
    std::istringstream lines(help.text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << program << ": " << line;
  }
}

// A map is judged by the room that it is of; by another room it is wrong.
TEST(Programs, EvalJudgesAMapByTheSimulatedRoom) {
  const TempFolder folder;
  ASSERT_EQ(once(folder, {}).status, 0);
  const auto judge = [&](const std::string& truth, const std::string& map) {
    return run(folder, "onemap-eval", {folder / "out/trajectory.txt", truth, "--surface", folder / map, "--json"});
  };
  for (const char* map : {"out/local.glb", "out/local.ply"}) {
    const Ran good = judge(kShortWalk, map);
    ASSERT_EQ(good.status, 0) << good.text;
    const auto surface = nlohmann::json::parse(good.text).at("surface");
    EXPECT_GT(surface.at("points").get<int>(), 10000);
    EXPECT_LT(surface.at("median").get<double>(), 0.006) << map;
    EXPECT_LT(surface.at("off").get<double>(), 0.05) << map;
  }
  std::string other = kShortWalk;
  other.replace(other.find("living-room"), 11, "storage");
  const Ran wrong = judge(other, "out/local.glb");
  EXPECT_TRUE(wrong.status != 0 || nlohmann::json::parse(wrong.text).at("surface").at("median").get<double>() > 0.02)
      << wrong.text;
  folder.write("groundtruth.txt", test::text_of(folder / "out/trajectory.txt"));
  const Ran recorded = judge(folder / "groundtruth.txt", "out/local.glb");
  EXPECT_EQ(recorded.status, 1);
  EXPECT_THAT(recorded.text, HasSubstr("known of simulated rooms only"));
  EXPECT_THAT(judge(kShortWalk, "out/trajectory.txt").text, HasSubstr("neither a .ply nor a .glb"));
}

TEST(Programs, TheExampleConfigurationIsOneThatWorks) {
  const TempFolder folder;
  const Ran example = run(folder, "onemapd", {"--help-config"});
  ASSERT_EQ(example.status, 0);
  folder.write("c.toml", example.text);
  const Ran ran = once(folder, {"--config", folder / "c.toml"});
  EXPECT_EQ(ran.status, 0) << ran.text;
}

TEST(Programs, WrongCommandLinesAndConfigurationsEndWithTwoAndTouchNothing) {
  const TempFolder folder;
  folder.write("nan.toml", "[map]\nvoxel_m = nan\n");
  folder.write("few.toml", "[tracking]\nmax_keyframes = 8\n");
  folder.write("deep.toml", "[map]\ntruncation_m = 2.1\n");
  folder.write("huge.toml",
               "[network]\nlisten = \"127.0.0.1:0\"\nstore_budget_mb = 65536\n"
               "[map]\nbudget_mb = 65536\nglobal_budget_mb = 65536\n");
  folder.write("slip.toml", "[map]\nvoxel = 0.05\n");
  const auto config = [&](const char* name) { return std::vector<std::string>{"--config", folder / name}; };
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {config("nan.toml"), "nan.toml:2: map.voxel_m"},
      {config("few.toml"), "few.toml:2: tracking.max_keyframes: 8 is not within 10 to 10000"},
      {config("deep.toml"), "deep.toml:2: map.truncation_m: 2.1 is not within 2 to 100 voxels"},
      {config("huge.toml"), "65536 + 2 * 65536 + 32 + 32 + 65536 = 262208 MB, but this"},
      {config("slip.toml"), "slip.toml:2: unknown key 'voxel' in [map]; did you mean 'voxel_m'?"},
      {config("."), "cannot read: Is a directory"},
      {{"--peer", "127.0.0.1:0"}, "has port 0"},
      {{"--peer", "[::1]:4600"}, "speaks only IPv4"},
      {{"--listen", "127.0.0.1:4600", "--peer", "127.0.0.1:4600"}, "is this robot itself"},
      {{"--listen", "300.1.1.1:1"}, "300.1.1.1"},
      {{"--speed", "nan"}, "--speed"},
      {{"--linger", "nan"}, "--linger"},
  };
  for (const auto& [more, why] : wrong) {
    const Ran ran = once(folder, more);
    EXPECT_EQ(ran.status, 2) << ran.text;
    EXPECT_THAT(ran.text, HasSubstr(why));
  }
  const std::pair<const char*, const char*> cameras[] = {{"teapot:earl-grey", "known: replay, simulated"},
                                                         {"living-room", "BACKEND:PLACE"},
                                                         {"simulated:living-room?legs=4", "legs"},
                                                         {"replay:x?fx=1e300", "fx: 1e300 is not within"},
                                                         {"v4l2:video0", "expected v4l2: or v4l2:/dev/videoN"},
                                                         {"v4l2:?fps=0", "fps=0: expected a whole number"},
                                                         {"openni2:?mode=big", "mode=big: expected WIDTHxHEIGHT@FPS"},
                                                         {"libusb:?tilt=3", "unknown option 'tilt'"},
                                                         {"libusb:?calibration=none.txt", "none.txt"}};
  for (const auto& [camera, why] : cameras) {
    const Ran ran = once(folder, {}, "out", camera);
    EXPECT_EQ(ran.status, 2) << ran.text;
    EXPECT_THAT(ran.text, HasSubstr(why));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Programs, WhatCannotBeOpenedOrMadeEndsWithOneAndSaysWhat) {
  const TempFolder folder;
  folder.write("file", "not a folder");
  auto taken = comms::UdpPort::open({comms::Endpoint::ipv4(127, 0, 0, 1, 0), {}});
  ASSERT_TRUE(taken.ok());
  const std::string port = comms::to_string((*taken)->local());
  const std::vector<std::pair<Ran, std::string>> failed{
      {once(folder, {"--listen", port}), port + ": cannot listen: Address already in use"},
      {once(folder, {"--listen", "192.0.2.1:4600"}), "192.0.2.1:4600: cannot listen: Cannot assign requested address"},
      {once(folder, {}, "file"), "cannot make the folder: "},
      {once(folder, {}, "file/below"), "cannot make the folder: Not a directory"},
      {once(folder, {}, "out", "replay:/nonexistent/place"), "no folder '/nonexistent/place'"},
  };
  for (const auto& [ran, why] : failed) {
    EXPECT_EQ(ran.status, 1) << ran.text;
    EXPECT_THAT(ran.text, HasSubstr(why));
  }
}

TEST(Programs, AFolderThatTakesNoFilesIsSaidBeforeTheWork) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "out");
  constexpr int kNoMount = 77;
  const std::string out = folder / "out";
  const std::string command = fmt::format(
      "unshare -m sh -c \"mount -t tmpfs -o ro none {0} || exit {1}; exec {2}/onemapd --camera '{3}' --once --out "
      "{0}\" "
      "2> {4} || exit $?",
      out, kNoMount, ONEMAP_BIN_DIR, kShortWalk, folder / "e");
  const int status = WEXITSTATUS(std::system(command.c_str()));
  const std::string said = test::text_of(folder / "e");
  if (status == kNoMount || said.find("unshare") != std::string::npos)
    GTEST_SKIP() << "no file system can be mounted here (needs root): " << said;
  EXPECT_EQ(status, 1) << said;
  EXPECT_THAT(said, HasSubstr(out + ": cannot write to the folder: Read-only file system"));
}

// A real recording whose depth is registered: a lens that begins a centimetre beside is found to be where colour's is.
TEST(Programs, OnemapctlCalibrateWritesACalibrationOfARecording) {
  const std::string recording = std::string(ONEMAP_SHARED_DIR) + "/data/fr1_xyz";
  if (!std::filesystem::exists(recording + "/rgb.txt")) GTEST_SKIP() << "recording not found: " << recording;
  const TempFolder folder;
  std::string text = "width 640\nheight 480\ndepth_width 640\ndepth_height 480\ncolour_from_depth_x 0.01\n";
  std::istringstream lines(test::text_of(recording + "/calibration.txt"));
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && line[0] != '#')
      text += line + "\n" + (line.starts_with("depth_") ? "" : "depth_" + line + "\n");
  folder.write("nominal.txt", text);
  const std::string out = folder / "mine.txt";
  const Ran ran = run(folder, "onemapctl", {"calibrate", recording, "--from", folder / "nominal.txt", "--out", out});
  ASSERT_EQ(ran.status, 0) << ran.text;
  EXPECT_THAT(ran.text, HasSubstr("a larger room gives the same images"));
  const auto rig = hal::imaging::parse_rig_calibration(test::text_of(out), out);
  ASSERT_TRUE(rig) << rig.error().text();
  EXPECT_NEAR(rig->pose.translation_m[0], 0, 0.004);
  EXPECT_NEAR(rig->pose.translation_m[1], 0, 0.006);
  const Ran again = run(folder, "onemapctl", {"--json", "calibrate", recording, "--from", folder / "nominal.txt"});
  const auto json = nlohmann::json::parse(again.text, nullptr, false);
  ASSERT_EQ(json.value("class", ""), "CALIBRATION") << again.text;
  EXPECT_NEAR(json.at("colour_from_depth_x").at("value").get<double>(), rig->pose.translation_m[0], 1e-6);
  EXPECT_GT(json.at("colour_from_depth_x").at("sigma").get<double>(), 0);
  EXPECT_TRUE(json.at("colour_from_depth_z").at("sigma").is_null()) << "no edge tells it";
  EXPECT_TRUE(json.at("depth_scale").at("sigma").is_null()) << "a larger room gives the same images";
  const Ran few = run(folder, "onemapctl", {"calibrate", recording + ":0:3", "--from", folder / "nominal.txt"});
  EXPECT_EQ(few.status, 1);
  EXPECT_THAT(few.text, HasSubstr("3 images are too few"));
  EXPECT_EQ(run(folder, "onemapctl", {"calibrate"}).status, 2);
}

// Of Femto Mega and Gemini 2: whatever was recorded, one of their lenses has images of another shape.
TEST(Programs, OnemapctlCalibrateSaysWhyACameraOfTwoShapesCannotBeCalibrated) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  for (const char* list : {"rgb", "depth"}) {
    folder.write(std::string("recording/") + list + ".txt", std::string("0.1 ") + list + ".png\n");
    const hal::imaging::ImageSize size{96, 54};
    std::vector<std::uint8_t> file;
    if (*list == 'r')
      ASSERT_TRUE(hal::imaging::encode_colour(size, std::vector<std::uint8_t>(3 * size.pixels(), 7), file));
    else
      ASSERT_TRUE(hal::imaging::encode_depth(size, std::vector<std::uint16_t>(size.pixels(), 7), file));
    folder.write(std::string("recording/") + list + ".png", std::string(file.begin(), file.end()));
  }
  folder.write("recording/calibration.txt", "fx 60\nfy 60\ncx 47.5\ncy 26.5\ndepth_scale 1000\n");
  const std::string nominal =
      std::string(ONEMAP_SOURCE_DIR) + "/hal/backends/v4l2/calibration/2bc5-0670-orbbec-gemini2.txt";
  const Ran ran = run(folder, "onemapctl", {"calibrate", recording, "--from", nominal});
  EXPECT_EQ(ran.status, 1);
  EXPECT_THAT(ran.text, testing::AllOf(HasSubstr("the calibration is for 640x400, and 96x54 has another shape"),
                                       HasSubstr("whose depth images have another shape cannot be calibrated")));
}

TEST(Programs, AFullStandardOutputIsAFailure) {
  const TempFolder folder;
  for (const char* what : {"onemapd --help", "onemapd --version", "onemapd --dump-config", "onemap-fleet --help",
                           "onemap-view --help", "onemap-eval --help", "onemap-calibrate --help", "onemapctl --help"}) {
    const std::string command = fmt::format("{}/{} > /dev/full 2> {}", ONEMAP_BIN_DIR, what, folder / "e");
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << what;
    EXPECT_THAT(test::text_of(folder / "e"), HasSubstr("standard output")) << what;
  }
}

TEST(Programs, WorkWhereChildrenAreIgnored) {
  const TempFolder folder;
  const std::string command =
      fmt::format("bash -c \"trap '' CHLD; exec {}/onemapd --camera '{}' --once --speed max --out {}\" 2> {}",
                  ONEMAP_BIN_DIR, kShortWalk, folder / "out", folder / "e");
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 0) << test::text_of(folder / "e");
}

// A folder's name may be any bytes, and what is written of it is text all the same.
TEST(Programs, ARecordingWhoseNameIsNoTextIsMappedAndReported) {
  const std::filesystem::path recording = std::filesystem::path(ONEMAP_SHARED_DIR) / "data/fr1_xyz";
  if (!std::filesystem::exists(recording)) GTEST_SKIP() << "the recording " << recording << " is not here";
  const TempFolder folder;
  const std::string name = "r\xff\x1b[31m\nroot: x";
  std::filesystem::create_directory_symlink(recording, folder / name);
  const std::string camera = "replay:" + folder / name + ":0:30";
  const std::string shown = "r\\xff\\x1b[31m\\x0aroot: x";
  const Ran alone = once(folder, {}, name + "-out", camera);
  EXPECT_EQ(alone.status, 0) << alone.text;
  EXPECT_THAT(alone.text, AllOf(HasSubstr(shown), Not(HasSubstr("\x1b")), Not(HasSubstr("\nroot"))));
  const auto report = test::read_json(folder / (name + "-out/report.json"));
  EXPECT_THAT(report.at("robots").at(0).at("camera").get<std::string>(), HasSubstr(shown));

  const Ran fleet = run(folder, "onemap-fleet", {"--robot", camera, "--out", folder / (name + "-fleet")});
  EXPECT_EQ(fleet.status, 0) << fleet.text;
  EXPECT_THAT(fleet.text, AllOf(HasSubstr(shown + "-fleet/robot1/local.png"), Not(HasSubstr("\x1b"))));
  const auto team = test::read_json(folder / (name + "-fleet/report.json"));
  EXPECT_THAT(team.at("robots").at(0).at("camera").get<std::string>(), HasSubstr(shown));

  const std::string map = folder / (name + "-out/local.ply");
  const Ran view = run(folder, "onemap-view", {map, "--ply", folder / (name + ".ply")});
  EXPECT_EQ(view.status, 0) << view.text;
  EXPECT_THAT(view.text, AllOf(HasSubstr(shown), Not(HasSubstr("\x1b"))));
  const std::string poses = folder / (name + "-out/trajectory.txt");
  const Ran eval = run(folder, "onemap-eval", {poses, (recording / "groundtruth.txt").string(), "--json"});
  EXPECT_EQ(eval.status, 0) << eval.text;
  const auto errors = nlohmann::json::parse(eval.text);
  EXPECT_THAT(errors.at("robots").at(0).at("estimate").get<std::string>(), HasSubstr(shown));
  const Ran plain = run(folder, "onemap-eval", {poses, (recording / "groundtruth.txt").string()});
  EXPECT_THAT(plain.text, AllOf(HasSubstr(shown), Not(HasSubstr("\x1b"))));
}

TEST(Programs, ErrorsQuoteNamesAsText) {
  const TempFolder folder;
  const std::string name = folder / "no\xff\x1b[31m\nroot: x", shown = "no\\xff\\x1b[31m\\x0aroot: x";
  for (const Ran& ran :
       {once(folder, {}, "out", "replay:" + name), once(folder, {"--config", name}),
        run(folder, "onemap-fleet", {"--robot", "replay:" + name, "--out", folder / "f"}),
        run(folder, "onemap-view", {name + ".ply", "--ply", "x.ply"}), run(folder, "onemap-eval", {name, name})}) {
    EXPECT_NE(ran.status, 0);
    EXPECT_THAT(ran.text, AllOf(HasSubstr(shown), Not(HasSubstr("\x1b")), Not(HasSubstr("\nroot"))));
  }
}

}  // namespace
}  // namespace onemap
