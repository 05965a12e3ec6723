#include "daemon/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/options.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

class ConfigFile : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("onemap_config_" + std::to_string(getpid()) + ".toml");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  Status load(const std::string& text) {
    std::ofstream(file_) << text;
    return load_config(file_.string(), config_);
  }
  // The reason and the line of a file that must be refused.
  std::string refused(const std::string& text, int line) {
    const Status status = load(text);
    EXPECT_FALSE(status.ok()) << text;
    if (status) return {};
    EXPECT_EQ(status.error().place, file_.string() + ":" + std::to_string(line)) << status.error().text();
    return status.error().reason;
  }
  std::filesystem::path file_;
  Config config_;
};

TEST_F(ConfigFile, SetsWhatItNamesAndLeavesTheRest) {
  const Config before;
  ASSERT_TRUE(load("[robot]\nid = \"anna\"\n[network]\npeers = [\"127.0.0.1:1\", \"127.0.0.1:2\"]\n"
                   "[run]\nonce = true\nspeed = 2.5\n[tracking]\nfeatures = \"orb\"\nmax_features = 300\n"
                   "[map]\nvoxel_m = 0.05\ntruncation_m = 0.2\nbudget_mb = 7\n")
                  .ok());
  EXPECT_EQ(config_.id, "anna");
  EXPECT_THAT(config_.peers, testing::ElementsAre("127.0.0.1:1", "127.0.0.1:2"));
  EXPECT_TRUE(config_.once);
  EXPECT_FALSE(config_.speed.max);
  EXPECT_DOUBLE_EQ(config_.speed.factor, 2.5);
  EXPECT_EQ(config_.mapper.features, mapping::DescriptorKind::orb);
  EXPECT_EQ(config_.mapper.max_features, 300);
  EXPECT_FLOAT_EQ(config_.mapper.map.voxel_m, 0.05f);
  EXPECT_EQ(config_.mapper.map.budget_bytes, 7u << 20);
  EXPECT_EQ(config_.mapper.max_keyframes, before.mapper.max_keyframes);
  EXPECT_EQ(config_.camera, before.camera);
}

TEST_F(ConfigFile, RefusesUnknownKeysWithTheirLine) {
  EXPECT_THAT(refused("[robot]\nid = \"a\"\nname = \"b\"\n", 3), AllOf(HasSubstr("'name'"), HasSubstr("camera")));
  EXPECT_THAT(refused("\n[wheels]\nleft = 1\n", 2), HasSubstr("'wheels'"));
  EXPECT_THAT(refused("camera = \"replay:x\"\n", 1), HasSubstr("unknown key 'camera'"));
}

TEST_F(ConfigFile, RefusesBadValuesWithTheirLine) {
  EXPECT_THAT(refused("[map]\n\nvoxel_m = 9.0\n", 3), AllOf(HasSubstr("map.voxel_m"), HasSubstr("0.5")));
  EXPECT_THAT(refused("[map]\nbudget_mb = \"many\"\n", 2), HasSubstr("expected a number"));
  EXPECT_THAT(refused("[tracking]\nmax_features = true\n", 2), HasSubstr("expected a number"));
  EXPECT_THAT(refused("[tracking]\nfeatures = \"sift\"\n", 2), HasSubstr("neither surf nor orb"));
  EXPECT_THAT(refused("[run]\nspeed = \"fast\"\n", 2), HasSubstr("max"));
  EXPECT_THAT(refused("[run]\nonce = 1\n", 2), HasSubstr("true or false"));
  EXPECT_THAT(refused("[network]\npeers = [\"a:1\", 2]\n", 2), HasSubstr("list"));
}

TEST_F(ConfigFile, RefusesWhatIsNotToml) { refused("[robot]\nid = \n", 2); }

TEST_F(ConfigFile, CommandLineGoesOverTheFile) {
  ASSERT_TRUE(load("[robot]\nid = \"anna\"\ncamera = \"replay:x\"\n[run]\nspeed = 2\n").ok());
  const auto parsed = parse_daemon_options({"--config", file_.string(), "--id", "bert", "--out", "o"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->id, "bert");
  EXPECT_EQ(parsed.value->camera, "replay:x");
  EXPECT_DOUBLE_EQ(parsed.value->speed.factor, 2);
}

TEST(DaemonOptions, TakesSeveralPeersAndSpeedMax) {
  const auto parsed = parse_daemon_options({"--camera", "replay:x", "--out", "o", "--peer", "127.0.0.1:1", "--peer",
                                            "127.0.0.1:2", "--speed", "max", "--once"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_THAT(parsed.value->peers, testing::ElementsAre("127.0.0.1:1", "127.0.0.1:2"));
  EXPECT_TRUE(parsed.value->speed.max);
  EXPECT_TRUE(parsed.value->once);
  EXPECT_FALSE(parsed.value->alone());
}

TEST(DaemonOptions, RefusesWithUsage) {
  const std::vector<std::vector<std::string>> wrong{
      {"--out", "o"},                                                // no camera
      {"--camera", "replay:x"},                                      // nowhere to write
      {"--camera", "replay:x", "--out", "o", "--speed", "0"},        // no speed
      {"--camera", "replay:x", "--out", "o", "--speed", "1x"},       //
      {"--camera", "replay:x", "--out", "o", "--features", "sift"},  //
      {"--camera", "replay:x", "--out", "o", "--id", "a b"},         // no name
      {"--camera", "replay:x", "--out", "o", "--wings"},             // unknown
      {"--camera", "replay:x", "--out", "o", "--config", "/nonexistent/onemap.toml"},
  };
  for (const auto& arguments : wrong) {
    const auto parsed = parse_daemon_options(arguments);
    EXPECT_FALSE(parsed.value) << testing::PrintToString(arguments);
    EXPECT_EQ(parsed.exit, Exit::usage);
    EXPECT_FALSE(parsed.text.empty());
  }
}

TEST(DaemonOptions, HelpNamesCamerasAndExitStatus) {
  const auto parsed = parse_daemon_options({"--help"});
  EXPECT_FALSE(parsed.value);
  EXPECT_EQ(parsed.exit, Exit::done);
  EXPECT_THAT(parsed.text, AllOf(HasSubstr("replay:DIR"), HasSubstr("simulated:"), HasSubstr("Exit status"),
                                 HasSubstr("--peer"), HasSubstr("--once")));
}

}  // namespace
}  // namespace onemap::daemon
