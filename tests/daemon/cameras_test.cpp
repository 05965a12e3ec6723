#include "daemon/cameras.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

#include "control/protocol.hpp"
#include "daemon/options.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

TEST(Cameras, TheListSaysWhatIsThereAndWhatAutoOpens) {
  const hal::CameraInfo cameras[] = {{"v4l2:/dev/video0", "An old one", "", "no colour node"},
                                     {"v4l2:/dev/video2", "A good one 123", "depth Z16 640x480", ""}};
  EXPECT_EQ(cameras_text(cameras),
            "v4l2:/dev/video0\n  An old one\n  cannot be used: no colour node\n"
            "v4l2:/dev/video2\n  A good one 123\n  depth Z16 640x480\nauto is v4l2:/dev/video2\n");
  EXPECT_THAT(cameras_text(std::span(cameras).first(1)), testing::EndsWith("none of them can be used\n"));
  EXPECT_THAT(cameras_text({}), testing::HasSubstr("no camera found"));
}

TEST(Cameras, TheListSaysItToProgramsAndACameraAtItsBestIsBefore) {
  const hal::CameraInfo cameras[] = {{"v4l2:/dev/video0", "One", "Z16", "", "is on USB 2"},
                                     {"openni2:a", "Another", "depth", ""}};
  const auto answer = control::Json::parse(cameras_json_text(cameras));
  EXPECT_EQ(answer.at("auto"), "openni2:a");
  EXPECT_EQ(answer.at("found").at(0).at("limits"), "is on USB 2");
  EXPECT_EQ(answer.at("found").at(1).at("abilities"), "depth");
  EXPECT_EQ(control::Json::parse(cameras_json_text(std::span(cameras).first(1))).at("auto"), "v4l2:/dev/video0");
  EXPECT_TRUE(control::Json::parse(cameras_json_text({})).at("auto").is_null());
}

TEST(Cameras, TheOptionEndsWithTheList) {
  const auto parsed = parse_daemon_options({"--cameras"});
  EXPECT_FALSE(parsed.value.has_value());
  EXPECT_EQ(parsed.exit, Exit::done);
  EXPECT_FALSE(parsed.text.empty());
  const auto json = parse_daemon_options({"--cameras", "--json"});
  EXPECT_EQ(json.exit, Exit::done);
  EXPECT_TRUE(control::Json::parse(json.text).at("found").is_array()) << json.text;
  EXPECT_EQ(parse_daemon_options({"--json"}).exit, Exit::usage);
}

// VENDOR and PRODUCT of the udev rules of one subsystem; a rule without a product is for all of a vendor's.
std::vector<std::pair<std::string, std::string>> ruled(const std::string& rules, const std::string& subsystem) {
  std::vector<std::pair<std::string, std::string>> found;
  std::istringstream in(rules);
  const std::regex vendor("ATTRS\\{idVendor\\}==\"([0-9a-f]{4})\""), products("ATTRS\\{idProduct\\}==\"([^\"]*)\"");
  std::smatch match;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("SUBSYSTEM==\"" + subsystem + "\"") || !std::regex_search(line, match, vendor)) continue;
    const std::string of = match[1];
    found.emplace_back(of, std::regex_search(line, match, products) ? match[1].str() : "*");
  }
  return found;
}

TEST(Cameras, ThoseWithACalibrationOfTheirOwnAreTheDaemonsByAUdevRule) {
  const std::filesystem::path root(ONEMAP_SOURCE_DIR);
  const auto rules = ruled(test::text_of(root / "systemd/70-onemap-cameras.rules"), "video4linux");
  ASSERT_FALSE(rules.empty());
  std::size_t cameras = 0;
  for (const auto& file : std::filesystem::directory_iterator(root / "hal/backends/v4l2/calibration")) {
    const std::string name = file.path().filename().string(), vendor = name.substr(0, 4), product = name.substr(5, 4);
    ++cameras;
    EXPECT_TRUE(std::ranges::any_of(rules, [&](const auto& rule) {
      return rule.first == vendor &&
             (rule.second == "*" || ("|" + rule.second + "|").find("|" + product + "|") != std::string::npos);
    })) << name;
  }
  EXPECT_GE(cameras, 7u);
}

TEST(Cameras, EveryBackendSaysHowItIsAddressed) {
  for (const hal::Backend& backend : camera_backends()) {
    EXPECT_THAT(std::string(backend.description), testing::HasSubstr(std::string(backend.name) + ":"));
    EXPECT_NE(backend.open, nullptr);
  }
}

}  // namespace
}  // namespace onemap::daemon
