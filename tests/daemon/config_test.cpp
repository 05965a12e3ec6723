#include "daemon/config.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "daemon/config_key.hpp"
#include "support/team_key.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class ConfigFile : public testing::Test {
 protected:
  Status load(const std::string& text) {
    folder_.write("c.toml", text);
    const auto errors = read_config(file_, config_);
    return errors.empty() ? success() : errors.front();
  }
  // The reason of a file that must be refused at this line.
  std::string refused(const std::string& text, int line) {
    const Status status = load(text);
    EXPECT_FALSE(status.ok()) << text;
    if (status) return {};
    EXPECT_EQ(status.error().place, fmt::format("{}:{}", file_, line)) << text << status.error().text();
    return status.error().reason;
  }
  const test::TempFolder folder_;
  const std::string file_ = folder_ / "c.toml";
  Config config_;
};

TEST_F(ConfigFile, SetsWhatItNamesAndLeavesTheRest) {
  const Config before;
  ASSERT_TRUE(load("[robot]\nid = \"anna\"\n[network]\npeers = [\"127.0.0.1:1\", \"127.0.0.1:2\"]\n"
                   "[run]\nonce = true\nspeed = 2.5\nlinger_s = 4\n[tracking]\nfeatures = \"orb\"\nmax_features = 300\n"
                   "[map]\nvoxel_m = 0.05\ntruncation_m = 0.2\nbudget_mb = 7\n")
                  .ok());
  EXPECT_EQ(config_.id, "anna");
  EXPECT_THAT(config_.peers, testing::ElementsAre("127.0.0.1:1", "127.0.0.1:2"));
  EXPECT_TRUE(config_.once);
  EXPECT_FALSE(config_.speed.max);
  EXPECT_DOUBLE_EQ(config_.speed.factor, 2.5);
  EXPECT_EQ(config_.linger_s, 4);
  EXPECT_EQ(config_.mapper.features, mapping::DescriptorKind::orb);
  EXPECT_EQ(config_.mapper.max_features, 300);
  EXPECT_FLOAT_EQ(config_.mapper.map.voxel_m, 0.05f);
  EXPECT_EQ(config_.mapper.map.budget_bytes, 7u << 20);
  EXPECT_EQ(config_.mapper.max_keyframes, before.mapper.max_keyframes);
  EXPECT_EQ(config_.camera, before.camera);
}

TEST_F(ConfigFile, RefusesUnknownKeysWithTheirLineAndTheNearest) {
  EXPECT_THAT(refused("[robot]\nid = \"a\"\nname = \"b\"\n", 3),
              AllOf(HasSubstr("unknown key 'name' in [robot]"), HasSubstr("known here: id, camera, out")));
  EXPECT_THAT(refused("[map]\nvoxel = 1\n", 2), HasSubstr("did you mean 'voxel_m'?"));
  EXPECT_THAT(refused("[tracking]\nmax_keyframe = 50\n", 2), HasSubstr("did you mean 'max_keyframes'?"));
  EXPECT_THAT(refused("[tracking]\nvoxel_m = 0.05\n", 2), HasSubstr("did you mean 'voxel_m' in [map]?"));
  EXPECT_THAT(refused("[run]\nsped = 1\n", 2), HasSubstr("did you mean 'speed'?"));
  EXPECT_THAT(refused("[run]\nwhatever_else = 1\n", 2), Not(HasSubstr("did you mean")));
  EXPECT_THAT(refused("\n[wheels]\nleft = 1\n", 2), AllOf(HasSubstr("'wheels'"), Not(HasSubstr("did you mean"))));
  EXPECT_THAT(refused("[maps]\nleft = 1\n", 1), HasSubstr("did you mean [map]?"));
  EXPECT_THAT(refused("camera = \"replay:x\"\n", 1), HasSubstr("unknown section 'camera'"));
  EXPECT_THAT(refused("map = 1\n", 1), HasSubstr("expected [map]"));
}

TEST_F(ConfigFile, RefusesBadValuesWithTheirLineAndWhatIsAccepted) {
  EXPECT_THAT(refused("[map]\n\nvoxel_m = 9.0\n", 3), AllOf(HasSubstr("map.voxel_m: 9 "), HasSubstr("0.001 to 1")));
  EXPECT_THAT(refused("[map]\nbudget_mb = \"many\"\n", 2), HasSubstr("expected a whole number, 1 to 65536"));
  EXPECT_THAT(refused("[map]\nbudget_mb = 2.5\n", 2), HasSubstr("expected a whole number"));
  EXPECT_THAT(refused("[map]\nbudget_mb = -1\n", 2), HasSubstr("-1 is not within 1 to 65536"));
  EXPECT_THAT(refused("[map]\nvoxel_m = \"0.02\"\n", 2), HasSubstr("expected a number"));
  EXPECT_THAT(refused("[tracking]\nmax_features = true\n", 2), HasSubstr("expected a whole number"));
  EXPECT_THAT(refused("[tracking]\nmax_features = 1979-05-27\n", 2), HasSubstr("expected 50 to 1000"));
  EXPECT_THAT(refused("[tracking]\nfeatures = \"sift\"\n", 2), HasSubstr("neither surf nor orb"));
  EXPECT_THAT(refused("[run]\nspeed = \"fast\"\n", 2), HasSubstr("max"));
  EXPECT_THAT(refused("[run]\nspeed = nan\n", 2), HasSubstr("expected max or a factor"));
  EXPECT_THAT(refused("[run]\nonce = 1\n", 2), HasSubstr("true or false"));
  EXPECT_THAT(refused("[network]\npeers = [\"127.0.0.1:1\", 2]\n", 2), HasSubstr("list"));
  EXPECT_THAT(refused("[network]\npeers = [\"a:1\"]\n", 2), HasSubstr("\"a\" is not a numeric IPv4 address"));
  EXPECT_THAT(refused("[network]\nlisten = \"127.0.0.1\"\n", 2), HasSubstr("no port"));
  EXPECT_THAT(refused("[network]\ngroup = \"10.0.0.2:1\"\n", 2), HasSubstr("no IPv4 multicast address"));
  EXPECT_THAT(refused("[robot]\nid = \"a b\"\n", 2), HasSubstr("1 to 16 characters"));
  EXPECT_THAT(refused("[robot]\ncamera = \"teapot:x\"\n", 2), HasSubstr("known: replay, simulated"));
}

// A start would fail for ever: the kernel's addresses of sockets are that short.
TEST_F(ConfigFile, PathsOfSocketsHaveTheLengthThatIsPrinted) {
  for (const auto& [section, most] : {std::pair{"control", 107}, std::pair{"poses", 102}}) {
    const auto text = [name = section](int size) {
      return fmt::format("[{}]\n\nsocket = \"/{}\"\n", name, std::string(static_cast<std::size_t>(size - 1), 'a'));
    };
    EXPECT_TRUE(load(text(most)).ok()) << section;
    EXPECT_THAT(refused(text(most + 1), 3),
                AllOf(HasSubstr(fmt::format("{}.socket", section)), HasSubstr(fmt::format("{} bytes", most + 1)),
                      HasSubstr(fmt::format("have {}", most))));
    EXPECT_THAT(find_key(section, "socket")->values, HasSubstr(fmt::format("at most {} bytes", most)));
  }
}

TEST_F(ConfigFile, OfWordsItSaysTheNearest) {
  const auto near = [](const std::string& word) { return HasSubstr("; did you mean \"" + word + "\"?"); };
  EXPECT_THAT(refused("[tracking]\nfeatures = \"surv\"\n", 2), AllOf(HasSubstr("neither surf nor orb"), near("surf")));
  EXPECT_THAT(refused("[tracking]\nfeatures = \"orbs\"\n", 2), near("orb"));
  EXPECT_THAT(refused("[run]\nfind_pairs = \"all_pairs\"\n", 2), near("all-pairs"));
  EXPECT_THAT(refused("[run]\nspeed = \"mx\"\n", 2), near("max"));
  EXPECT_THAT(refused("[snapshots]\nviews = [\"fit\", \"folow\"]\n", 2),
              AllOf(HasSubstr("\"folow\" is not one of \"fit\", \"top\""), near("follow")));
  EXPECT_THAT(refused("[record]\nformats = [\"tom\"]\n", 2), near("tum"));
  EXPECT_THAT(refused("[snapshots]\nviews = [\"tpo\"]\n", 2), near("top")) << "two letters that changed places";
  EXPECT_THAT(refused("[robot]\ncamera = \"simulatd:office\"\n", 2), near("simulated"));
  EXPECT_THAT(refused("[robot]\ncamera = \"autoo\"\n", 2), AllOf(HasSubstr("or auto"), near("auto")));
  for (const char* far : {"[tracking]\nfeatures = \"sift\"\n", "[snapshots]\nviews = [\"moonlight\"]\n",
                          "[snapshots]\nviews = [\"fit\", \"fit\"]\n", "[run]\nspeed = \"fastest\"\n",
                          "[robot]\ncamera = \"teapot:office\"\n", "[robot]\ncamera = \"simulated:offfice\"\n"})
    EXPECT_THAT(refused(far, 2), Not(HasSubstr("did you mean"))) << far;
}

TEST_F(ConfigFile, WhatIsNotANumberIsRefusedForEveryKey) {
  for (const ConfigKey& key : config_keys())
    for (const char* value : {"nan", "-nan", "inf", "-inf", "1e300", "-1"})
      EXPECT_NE(refused(fmt::format("[{}]\n{} = {}\n", key.section, key.name, value), 2), "")
          << key.full_name() << " = " << value;
}

TEST_F(ConfigFile, SaysEverythingThatIsWrongAndKeepsTheRest) {
  folder_.write("c.toml", "[run]\nsped = 1\nonce = true\nlinger_s = -1\n[wheels]\n[map]\nvoxel_m = \"x\"\n");
  const auto errors = read_config(file_, config_);
  std::vector<std::string> places;
  for (const Error& error : errors) places.push_back(error.place.substr(file_.size()));
  EXPECT_THAT(places, testing::UnorderedElementsAre(":2", ":4", ":5", ":7"));
  EXPECT_TRUE(config_.once);
  EXPECT_EQ(config_.linger_s, Config().linger_s);
}

TEST_F(ConfigFile, RemembersWhereEachValueIsFrom) {
  ASSERT_TRUE(load("[map]\nvoxel_m = 0.03\n\nbudget_mb = 9\n").ok());
  EXPECT_EQ(config_.origins.at("map.voxel_m"), file_ + ":2");
  EXPECT_EQ(config_.origins.at("map.budget_mb"), file_ + ":4");
  EXPECT_EQ(config_.origins.size(), 2u);
  EXPECT_THAT(origins_text(config_), AllOf(HasSubstr("voxel_m = 0.03  # from " + file_ + ":2\n"),
                                           HasSubstr("once = false  # from default\n")));
  const Config before = config_;
  ASSERT_TRUE(load(origins_text(before)).ok()) << "what is printed can be read";
  EXPECT_EQ(config_text(config_), config_text(before));
}

// What the mapper asks of values together, found at the line of the one that is wrong.
TEST_F(ConfigFile, RefusesWhatDoesNotFitTogether) {
  config_.id = "a";
  config_.out = "o";
  const auto wrong = [this](const std::string& text) {
    EXPECT_TRUE(load(text).ok()) << text;
    return check_config(config_).error();
  };
  EXPECT_EQ(wrong("[map]\ntruncation_m = 2.5\n").place, file_ + ":2");
  EXPECT_THAT(wrong("[map]\ntruncation_m = 0.03\n").text(), HasSubstr("within 2 to 100 voxels of 0.02 m"));
  config_.mapper.map.truncation_m = Config().mapper.map.truncation_m;
  config_.origins.clear();
  const Error by_default = wrong("[map]\nvoxel_m = 0.05\n");
  EXPECT_EQ(by_default.text(), "map.truncation_m: 0.06 is not within 2 to 100 voxels of 0.05 m")
      << "the truncation that does not fit is nowhere said";
  config_ = {};
  EXPECT_THAT(refused("[tracking]\nmax_keyframes = 8\n", 2), HasSubstr("8 is not within 10 to 10000"));
}

TEST_F(ConfigFile, RefusesWhatIsNotToml) {
  refused("[robot]\nid = \n", 2);
  EXPECT_NE(refused("[robot]\nid = \"a\"\nid = \"b\"\n", 3), "") << "a key given twice";
  EXPECT_NE(refused("[robot]\nid = \"a\"\n[map]\n[robot]\n", 4), "") << "a section given twice";
  EXPECT_NE(refused("[robot]\nid = \"\xff\"\n", 2), "") << "not UTF-8";
}

TEST_F(ConfigFile, AFileThatCannotBeReadIsAnError) {
  const auto text = [this](const std::string& file) { return read_config(file, config_).at(0).text(); };
  EXPECT_THAT(text(folder_ / "none.toml"), HasSubstr("none.toml: cannot read: No such"));
  EXPECT_THAT(text(folder_.path().string()), HasSubstr("cannot read: Is a directory"));
}

TEST_F(ConfigFile, TheCommentedExampleHoldsEveryKeyWithItsDefault) {
  const std::string example = config_text({});
  ASSERT_TRUE(load(example).ok());
  EXPECT_EQ(config_text(config_), example) << "read back, every key has its default";
  std::size_t at = 0;
  for (const ConfigKey& key : config_keys()) {
    EXPECT_GE(key.text.size(), 12u) << key.full_name();
    EXPECT_FALSE(key.values.empty()) << key.full_name();
    const std::string entry = fmt::format("# {}\n#   {}\n{} = ", key.text, key.values, key.name);
    const std::size_t found = example.find(entry, at);
    EXPECT_NE(found, std::string::npos) << key.full_name();
    at = found == std::string::npos ? at : found;
  }
}

TEST_F(ConfigFile, TheExampleCarriesEveryValue) {
  Config all;
  all.id = "anna";
  all.camera = "replay:a\\b \"c\" \t\x7f";
  all.out = "o";
  all.listen = "[::]:4600";
  all.peers = {"10.0.0.2:1", "[fd00::2]:2"};
  all.group = "239.77.1.1:4600";
  all.team_key_file = "/k/team.key";
  all.key_log = "keys.log";
  all.bytes_per_second = 123456;
  all.link_bytes_per_second = 50'000;
  all.link_mb_per_day = 700;
  all.store_budget_bytes = 3u << 20;
  all.keep_log = false;
  all.once = true;
  all.quick_stop = true;
  all.speed = {true, 1};
  all.linger_s = 0.125;
  all.merge_while_mapping_s = 1e6;
  all.map_interval_s = 7;
  all.new_chain_after_s = 9;
  all.chain_keyframes = 123;
  all.lost_after_s = 77;
  all.peer_wait_s = 0;
  all.matches_picture = 9;
  all.control_socket = "c.sock";
  all.control_tcp = "127.0.0.1:4680";
  all.control_metrics = "[::1]:9464";
  all.preset = MapPreset::fine;
  all.mapper.features = mapping::DescriptorKind::orb;
  all.mapper.max_features = 51;
  all.mapper.max_keyframes = 11;
  all.mapper.keyframe_translation_m = 0.2;
  all.mapper.keyframe_rotation_deg = 3;
  all.mapper.min_motion_m = 0.5;
  all.mapper.min_motion_deg = 0.7;
  all.mapper.seed = INT64_MAX;
  all.mapper.map.voxel_m = 0.003f;
  all.mapper.map.truncation_m = 0.1f;
  all.mapper.map.max_depth_m = 7.3f;
  all.mapper.map.budget_bytes = 5u << 20;
  all.global_budget_bytes = 6u << 20;
  all.places_budget_bytes = 7u << 20;
  all.plan.space.cell_m = 0.1;
  all.refresh_plan = false;
  all.plan.space.budget_bytes = 9u << 20;
  all.find_pairs = mapping::FindPairs::all_pairs;
  all.record = {true, {"mcap"}, 10u << 20, 11u << 20};
  all.poses_socket = "/run/onemap/poses";
  all.snapshots = {12.5, true, 13, 14u << 20, {"front"}, {"glb"}, {"local"}};
  ASSERT_TRUE(load(config_text(all)).ok()) << load(config_text(all)).error().text();
  EXPECT_EQ(config_text(config_), config_text(all));
  for (const ConfigKey& key : config_keys())
    EXPECT_NE(key.get(config_), key.get(Config())) << key.full_name() << " was not carried";
  EXPECT_EQ(config_.mapper.map.voxel_m, all.mapper.map.voxel_m) << "bit for bit";
}

// What is printed as accepted is what is accepted.
TEST_F(ConfigFile, TheBoundsOfEveryNumberAreThoseThatArePrinted) {
  int numbers = 0;
  for (const ConfigKey& key : config_keys()) {
    const ConfigValue known = key.get(Config());
    if (!std::holds_alternative<std::int64_t>(known) && !std::holds_alternative<double>(known)) continue;
    if (key.name == "speed") continue;
    ++numbers;
    const bool whole = std::holds_alternative<std::int64_t>(known);
    const auto number = [whole](const std::string& text) -> ConfigValue {
      if (whole) return std::int64_t{std::stoll(text)};
      return std::stod(text);
    };
    const std::size_t to = key.values.find(" to ");
    ASSERT_NE(to, std::string::npos) << key.full_name();
    const std::string least = key.values.substr(0, to), most = key.values.substr(to + 4);
    Config config;
    for (const std::string& bound : {least, most}) {
      EXPECT_TRUE(key.set(number(bound), config).ok()) << key.full_name() << " = " << bound;
      EXPECT_EQ(std::stod(toml_text(key.get(config))), std::stod(bound)) << key.full_name();
    }
    if (whole) {
      EXPECT_FALSE(key.set(std::int64_t{std::stoll(least) - 1}, config).ok()) << key.full_name();
      if (most != std::to_string(INT64_MAX)) {
        EXPECT_FALSE(key.set(std::int64_t{std::stoll(most) + 1}, config).ok()) << key.full_name();
      }
    } else {
      EXPECT_FALSE(key.set(std::stod(least) - 1e-3, config).ok()) << key.full_name();
      EXPECT_FALSE(key.set(std::stod(most) * 1.001, config).ok()) << key.full_name();
    }
  }
  EXPECT_GE(numbers, 18);
}

TEST(CheckConfig, AsksForWhatADaemonCannotDoWithout) {
  Config config;
  config.id = "a";
  EXPECT_EQ(config.camera, "auto") << "a robot that has a camera needs no other line";
  EXPECT_THAT(check_config(config).error().text(), HasSubstr("--out OUT"));
  config.out = "o";
  EXPECT_TRUE(check_config(config).ok());
  config.camera = "";
  EXPECT_THAT(check_config(config).error().text(), HasSubstr("--camera ADDRESS"));
  config.camera = "replay:x";
  config.id = "../a";
  EXPECT_THAT(check_config(config).error().text(), HasSubstr("'../a'"));
}

// At the line that names it; what nobody named and a robot alone does not need is not asked for.
TEST(CheckConfig, AsksForTheKeysThatTheStartReads) {
  const test::TempFolder folder;
  Config config;
  config.id = "a";
  config.out = folder / "out";
  config.team_key_file = folder / "team.key";
  config.origins["team.key_file"] = "c.toml:7";
  EXPECT_THAT(check_config(config).error().text(),
              AllOf(testing::StartsWith("c.toml:7: team.key_file: " + config.team_key_file), HasSubstr("No such file"),
                    HasSubstr("onemapctl team join")));
  EXPECT_EQ(test::team_key(folder), config.team_key_file);
  EXPECT_TRUE(check_config(config).ok()) << check_config(config).error().text();
  config.listen = "127.0.0.1:0";
  EXPECT_TRUE(check_config(config).ok()) << "what is not there yet is made";
  folder.write("out/known_robots", "bert 12\n");
  EXPECT_THAT(check_config(config).error().text(), HasSubstr("known_robots:1: expected a robot's name and its key"));
  folder.write("out/identity", "spoilt\n");
  std::filesystem::permissions(folder / "out/identity", std::filesystem::perms::owner_read);
  EXPECT_THAT(check_config(config).error().text(), HasSubstr("identity: is not a robot's key"));
  config.listen.clear();
  EXPECT_TRUE(check_config(config).ok()) << "alone it needs neither";
}

TEST(CheckConfig, AsksTheMapper) {
  Config config;
  config.id = "a";
  config.camera = "replay:x";
  config.out = "o";
  config.mapper.map.voxel_m = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(check_config(config).error().place, "map.voxel_m");
  config.mapper.map.voxel_m = 0.02f;
  config.mapper.max_keyframes = 8;
  EXPECT_EQ(check_config(config).error().place, "tracking.max_keyframes");
}

TEST(CheckCamera, AsksWhetherTheMapperCanWorkWithIt) {
  Config config;
  EXPECT_TRUE(check_camera(config, {}).ok());
  config.mapper.map.budget_bytes = 1u << 20;
  EXPECT_EQ(check_camera(config, {}).error().place, "map.budget_mb");
  hal::Intrinsics camera;
  camera.fx = 1e300;
  EXPECT_EQ(check_camera(Config(), camera).error().place, "camera.fx");
}

TEST(IdFromHost, IsAlwaysAValidId) {
  EXPECT_EQ(id_from_host("kitchen-robot"), "kitchen-robot");
  EXPECT_EQ(id_from_host("Kitchen.lan"), "Kitchen.lan");
  EXPECT_EQ(id_from_host("a_rather_long_host_name"), "a_rather_long_ho");
  EXPECT_EQ(id_from_host("b\xC3\xA4r/1 2"), "b--r-1-2");
  EXPECT_EQ(id_from_host(".hidden"), "-hidden");
  EXPECT_EQ(id_from_host(""), "robot");
  EXPECT_FALSE(host_name().empty());
}

}  // namespace
}  // namespace onemap::daemon
