#include "daemon/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config_key.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Parsed<Config> parse(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"--camera", "replay:x", "--out", "o"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return parse_daemon_options(arguments);
}

TEST(DaemonOptions, CommandLineGoesOverTheFile) {
  const test::TempFolder folder;
  folder.write("c.toml", "[robot]\nid = \"anna\"\ncamera = \"replay:x\"\n[run]\nspeed = 2\n[map]\nbudget_mb = 7\n");
  const auto parsed = parse_daemon_options({"--config", folder / "c.toml", "--id", "bert", "--out", "o"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->id, "bert");
  EXPECT_EQ(parsed.value->camera, "replay:x");
  EXPECT_DOUBLE_EQ(parsed.value->speed.factor, 2);
  EXPECT_EQ(parsed.value->mapper.map.budget_bytes, 7u << 20);
}

TEST(DaemonOptions, TakesEveryOption) {
  const auto parsed =
      parse({"--id", "a", "--listen", "127.0.0.1:0", "--peer", "127.0.0.1:1", "--peer", "127.0.0.1:2", "--speed", "max",
             "--once", "--features", "orb", "--linger", "0.5", "--matches-picture", "7", "--map-preset", "fine"});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->id, "a");
  EXPECT_EQ(parsed.value->out, "o");
  EXPECT_EQ(parsed.value->listen, "127.0.0.1:0");
  EXPECT_THAT(parsed.value->peers, testing::ElementsAre("127.0.0.1:1", "127.0.0.1:2"));
  EXPECT_TRUE(parsed.value->speed.max);
  EXPECT_TRUE(parsed.value->once);
  EXPECT_EQ(parsed.value->mapper.features, mapping::DescriptorKind::orb);
  EXPECT_EQ(parsed.value->linger_s, 0.5);
  EXPECT_EQ(parsed.value->matches_picture, 7);
  EXPECT_EQ(parsed.value->mapper.map.voxel_um(), 10'000);
  EXPECT_FALSE(parsed.value->alone());
}

TEST(DaemonOptions, TheIdIsTheHostsUnlessOneIsGiven) {
  const auto parsed = parse({});
  ASSERT_TRUE(parsed.value) << parsed.text;
  EXPECT_EQ(parsed.value->id, id_from_host(host_name()));
}

TEST(DaemonOptions, RefusesWithUsageAndSaysWhichOption) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"--speed", "0"}, "--speed"},
      {{"--speed", "nan"}, "--speed"},
      {{"--speed", "inf"}, "--speed"},
      {{"--speed", "-1"}, "--speed"},
      {{"--speed", "1x"}, "--speed"},
      {{"--speed", ""}, "--speed"},
      {{"--linger", "nan"}, "--linger: nan is not within 0 to 1000000"},
      {{"--linger", "inf"}, "--linger"},
      {{"--linger", "-1"}, "--linger"},
      {{"--linger=-1"}, "--linger: -1 is not within"},
      {{"--linger", "soon"}, "--linger: expected a number"},
      {{"--matches-picture", "-5"}, "--matches-picture"},
      {{"--matches-picture", "2.5"}, "--matches-picture: expected a whole number"},
      {{"--matches-picture", "99999999999999999999"}, "--matches-picture"},
      {{"--features", "sift"}, "--features: \"sift\" is neither surf nor orb"},
      {{"--map-preset", "fin"}, "did you mean \"fine\"?"},
      {{"--id", "a b"}, "--id: 'a b'"},
      {{"--id", ""}, "--id: is given but empty"},
      {{"--id", "a", "--id", "b"}, "--id"},
      {{"--id", "../../etc"}, "--id"},
      {{"--camera", "", "--out", "o"}, "--camera"},
      {{"--listen", "300.1.1.1:1"}, "--listen"},
      {{"--peer", "10.0.0.2"}, "--peer"},
      {{"--peer", "10.0.0.2:0"}, "--peer: \"10.0.0.2:0\" has port 0"},
      {{"--peer", "[fd00::2]:4600"}, "speaks only IPv4"},
      {{"--wings"}, "--wings"},
      {{"stray"}, "stray"},
      {{"--config", "/nonexistent/onemap.toml"}, "/nonexistent/onemap.toml: cannot read: No such file"},
      {{"--config", "/tmp"}, "/tmp: cannot read: Is a directory"},
  };
  for (const auto& [arguments, why] : wrong) {
    const auto parsed = parse(arguments);
    EXPECT_FALSE(parsed.value) << testing::PrintToString(arguments);
    EXPECT_EQ(parsed.exit, Exit::usage) << testing::PrintToString(arguments);
    EXPECT_THAT(parsed.text, AllOf(testing::StartsWith("onemapd: "), HasSubstr(why)));
  }
  Surroundings bare;
  bare.variable = [](const char*) { return std::string(); };
  EXPECT_EQ(parse_daemon_options({"--camera", "replay:x"}, bare).exit, Exit::usage) << "nowhere to write";
}

TEST(DaemonOptions, RefusesCameraAddressesThatCannotBeRight) {
  for (const char* camera : {"teapot:earl-grey", "living-room", "simulated:attic", "simulated:office?legs=4",
                             "simulated:office?frames=nan", "replay:x?fx=1e300", "replay:x?fx=525&fx=525"}) {
    const auto parsed = parse_daemon_options({"--camera", camera, "--out", "o"});
    EXPECT_FALSE(parsed.value) << camera;
    EXPECT_EQ(parsed.exit, Exit::usage);
    EXPECT_THAT(parsed.text, AllOf(HasSubstr("--camera: "), HasSubstr(camera)));
  }
}

TEST(DaemonOptions, WhatIsQuotedCannotForgeLines) {
  const auto parsed = parse({"--peer", "x\nroot: y\x1b[31m\xff"});
  EXPECT_THAT(parsed.text, HasSubstr("x\\x0aroot: y\\x1b[31m\\xff"));
}

TEST(DaemonOptions, BudgetsBeyondThisMachineAreRefusedWithTheFigures) {
  const test::TempFolder folder;
  folder.write("c.toml",
               "[network]\nlisten = \"127.0.0.1:0\"\nstore_budget_mb = 65536\n[map]\nbudget_mb = 65536\n"
               "global_budget_mb = 65536\n");
  const auto parsed = parse({"--config", folder / "c.toml"});
  EXPECT_FALSE(parsed.value) << "or this machine has 256 GB";
  EXPECT_EQ(parsed.exit, Exit::usage);
  EXPECT_THAT(parsed.text, AllOf(HasSubstr("map.budget_mb + 2 * map.global_budget_mb + "),
                                 HasSubstr("65536 + 2 * 65536 + 32 + 32 + 65536 = 262208 MB, but this ")));
}

TEST(DaemonOptions, HelpNamesCamerasExitStatusAndTheId) {
  const auto parsed = parse_daemon_options({"--help"});
  EXPECT_FALSE(parsed.value);
  EXPECT_EQ(parsed.exit, Exit::done);
  EXPECT_THAT(parsed.text,
              AllOf(HasSubstr("replay:DIR"), HasSubstr("simulated:"), HasSubstr("Exit status"), HasSubstr("--peer"),
                    HasSubstr("--once"), HasSubstr("--help-config"), HasSubstr("here " + id_from_host(host_name()))));
}

TEST(DaemonOptions, HelpConfigAndVersionAskForNothingElse) {
  const auto help = parse_daemon_options({"--help-config"});
  EXPECT_FALSE(help.value);
  EXPECT_EQ(help.exit, Exit::done);
  EXPECT_EQ(help.text, config_text({}));
  const auto version = parse_daemon_options({"--version"});
  EXPECT_FALSE(version.value);
  EXPECT_EQ(version.exit, Exit::done);
  EXPECT_THAT(version.text, testing::MatchesRegex("onemapd [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

}  // namespace
}  // namespace onemap::daemon
