#include "daemon/config_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "daemon/config_key.hpp"
#include "daemon/options.hpp"
#include "team_key.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ConfigFiles : public testing::Test {
 protected:
  ConfigFiles() {
    std::filesystem::create_directory(folder_.path() / "onemap.toml.d");
    around_.config_file = file_;
    around_.variable = [this](const char* name) {
      const auto found = environment_.find(name);
      return found == environment_.end() ? std::string() : found->second;
    };
  }
  Parsed<Config> parse(const std::vector<std::string>& arguments) { return parse_daemon_options(arguments, around_); }

  const test::TempFolder folder_;
  const std::string file_ = folder_ / "onemap.toml";
  std::map<std::string, std::string> environment_{{"STATE_DIRECTORY", "/var/lib/x:/var/lib/y"}};
  Surroundings around_;
};

TEST_F(ConfigFiles, WithoutAFileARobotHasItsDefaults) {
  const auto parsed = parse({});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->camera, "auto");
  EXPECT_EQ(parsed.value->out, "/var/lib/x") << "the first of the list";
  EXPECT_TRUE(parsed.value->alone());
}

TEST_F(ConfigFiles, DropInsGoOverTheFileByNameAndTheCommandLineOverAll) {
  folder_.write("onemap.toml", "[run]\nlinger_s = 1\nlost_after_s = 1\npeer_wait_s = 1\nonce = true\n");
  folder_.write("onemap.toml.d/20-b.toml", "[run]\nlinger_s = 3\nlost_after_s = 3\n");
  folder_.write("onemap.toml.d/10-a.toml", "[run]\nlinger_s = 2\nlost_after_s = 2\npeer_wait_s = 2\n");
  folder_.write("onemap.toml.d/.30-hidden.toml", "[nonsense]\n");
  folder_.write("onemap.toml.d/30-old.toml~", "[nonsense]\n");
  const auto parsed = parse({"--linger", "4"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->linger_s, 4);
  EXPECT_EQ(parsed.value->lost_after_s, 3);
  EXPECT_EQ(parsed.value->peer_wait_s, 2);
  EXPECT_TRUE(parsed.value->once);
  const auto& origins = parsed.value->origins;
  EXPECT_EQ(origins.at("run.linger_s"), "command line");
  EXPECT_EQ(origins.at("run.lost_after_s"), file_ + ".d/20-b.toml:3");
  EXPECT_EQ(origins.at("run.peer_wait_s"), file_ + ".d/10-a.toml:4");
  EXPECT_EQ(origins.at("run.once"), file_ + ":5");
}

TEST_F(ConfigFiles, ANamedFileReplacesTheDefaultOneAndItsDropIns) {
  folder_.write("onemap.toml", "[run]\nlinger_s = 1\n");
  folder_.write("onemap.toml.d/a.toml", "[run]\nlost_after_s = 2\n");
  folder_.write("other.toml", "[run]\npeer_wait_s = 3\n");
  std::filesystem::create_directory(folder_.path() / "other.toml.d");
  folder_.write("other.toml.d/a.toml", "[run]\nspeed = 4\n");
  const auto parsed = parse({"--config", folder_ / "other.toml"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->linger_s, Config().linger_s);
  EXPECT_EQ(parsed.value->lost_after_s, Config().lost_after_s);
  EXPECT_EQ(parsed.value->peer_wait_s, 3);
  EXPECT_EQ(parsed.value->speed.factor, 4);
  EXPECT_TRUE(parse({"--config", "/dev/null"}).value) << "no file at all";
  EXPECT_EQ(parse({"--config", folder_ / "none.toml"}).exit, Exit::usage);
}

TEST_F(ConfigFiles, CheckConfigSaysEverythingThatIsWrongAnywhere) {
  folder_.write("onemap.toml", "[run]\nlinger = 1\n[map]\nvoxel_m = 9\n");
  folder_.write("onemap.toml.d/a.toml", "[robot]\nid = \"a b\"\n");
  const auto parsed = parse({"--check-config", "--speed", "0"});
  EXPECT_FALSE(parsed.value);
  EXPECT_EQ(parsed.exit, Exit::usage);
  EXPECT_THAT(parsed.text, AllOf(HasSubstr("onemap.toml:2: unknown key 'linger' in [run]; did you mean 'linger_s'?"),
                                 HasSubstr("onemap.toml:4: map.voxel_m: 9 is not within"),
                                 HasSubstr("onemap.toml.d/a.toml:2: robot.id:"), HasSubstr("--speed: ")));
  folder_.write("onemap.toml", "");
  folder_.write("onemap.toml.d/a.toml", "[map]\nvoxel_m = 0.02\ntruncation_m = 2.5\n");
  EXPECT_THAT(parse({"--check-config"}).text, HasSubstr("a.toml:3: map.truncation_m: 2.5 is not within"));
  folder_.write("onemap.toml.d/a.toml", "[map]\nvoxel_m = 0.02\n");
  const auto good = parse({"--check-config"});
  EXPECT_FALSE(good.value);
  EXPECT_EQ(good.exit, Exit::done);
}

TEST_F(ConfigFiles, TheErrorOfAWrongPeerIsWhereThePeersAre) {
  folder_.write("onemap.toml", "[network]\nlisten = \"127.0.0.1:4600\"\n\npeers = [\"127.0.0.1:4600\"]\n");
  EXPECT_THAT(parse({"--check-config"}).text,
              HasSubstr("onemap.toml:4: network.peers: \"127.0.0.1:4600\" is this robot"));
}

TEST_F(ConfigFiles, DumpConfigSaysWhatHoldsAndWhereItIsFrom) {
  folder_.write("onemap.toml", "[map]\nvoxel_m = 0.03\n");
  const auto dump = parse({"--dump-config", "--id", "anna"});
  EXPECT_EQ(dump.exit, Exit::done);
  EXPECT_THAT(dump.text, AllOf(HasSubstr("id = \"anna\"  # from command line\n"),
                               HasSubstr("out = \"/var/lib/x\"  # from default, $STATE_DIRECTORY\n"),
                               HasSubstr("voxel_m = 0.03  # from " + file_ + ":2\n"),
                               HasSubstr("camera = \"auto\"  # from default\n")));
  folder_.write("dumped.toml", dump.text);
  const auto again = parse({"--config", folder_ / "dumped.toml"});
  ASSERT_TRUE(again.value) << again.text;
  EXPECT_EQ(again.value->id, "anna");
}

TEST_F(ConfigFiles, ARobotWithATeamKeyNeedsNoOtherLineToMeetItsTeam) {
  const std::string key = test::team_key(folder_);
  environment_["STATE_DIRECTORY"] = folder_.path().string();
  const std::string group = "group = \"239.77.1.1:4600\"  # from default, there is a team key\n";
  EXPECT_THAT(parse({"--dump-config"}).text, HasSubstr(group));
  EXPECT_THAT(parse({"--dump-config", "--out", "o", "--team-key", key}).text, HasSubstr(group));
  folder_.write("onemap.toml", config_text({}));
  EXPECT_THAT(parse({"--dump-config"}).text, HasSubstr(group)) << "the example as it is";
  const auto parsed = parse({});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_FALSE(parsed.value->alone());
}

TEST_F(ConfigFiles, WhoSaysSomethingOfTheNetworkHasNoKeyOrPlaysOnceIsInNoGroupByDefault) {
  const std::string key = test::team_key(folder_);
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--team-key", key, "--once"},
                                             {"--team-key", key, "--listen", "0.0.0.0:4600"},
                                             {"--team-key", key, "--peer", "10.0.0.2:4600"},
                                             {"--team-key", "none"},
                                             {}}) {
    const auto parsed = parse(arguments);
    ASSERT_TRUE(parsed.value) << parsed.text;
    EXPECT_EQ(parsed.value->group, "") << testing::PrintToString(arguments);
  }
  folder_.write("onemap.toml", "[network]\ngroup = \"239.1.2.3:4600\"\n");
  EXPECT_EQ(parse({"--team-key", key}).value.value_or(Config()).group, "239.1.2.3:4600");
}

TEST_F(ConfigFiles, AUsersStateIsWhereXdgHasIt) {
  environment_ = {{"HOME", "/home/u"}};
  EXPECT_EQ(default_out(around_).folder, "/home/u/.local/state/onemap");
  environment_["XDG_STATE_HOME"] = "/elsewhere";
  EXPECT_EQ(default_out(around_).folder, "/elsewhere/onemap");
  environment_["XDG_STATE_HOME"] = "not/absolute";
  EXPECT_EQ(default_out(around_).folder, "/home/u/.local/state/onemap");
  environment_ = {};
  EXPECT_EQ(default_out(around_).folder, "");
}

TEST_F(ConfigFiles, ADropInFolderThatIsNoneIsAnError) {
  std::filesystem::remove(file_ + ".d");
  folder_.write("onemap.toml.d", "");
  EXPECT_THAT(parse({}).text, HasSubstr("onemap.toml.d: cannot read the drop-ins: Not a directory"));
}

}  // namespace
}  // namespace onemap::daemon
