// Real daemons with a team's key: over loopback through the emulated links, and beside those who have none or another.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/running.hpp"
#include "support/team_key.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::at;
using test::TempFolder;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kWalk = "simulated:office?width=320&height=240&frames=100000&robots=2&robot=";

TEST(KeyedTeam, ThreeRobotsEndWithOneDigest) {
  const TempFolder folder;
  ASSERT_EQ(test::run("onemapctl", {"team", "init", "--file", folder / "team.key"}, folder / "init.txt"), 0)
      << test::text_of(folder / "init.txt");
  const int code =
      test::run("onemap-fleet",
                {"--simulate", "3", "--frames", "60", "--seed", "3", "--loss", "5%", "--team-key", folder / "team.key",
                 "--timeout", std::to_string(test::kPatience * 120), "--out", folder / "out"},
                folder / "fleet.txt");
  ASSERT_EQ(code, 0) << test::text_of(folder / "fleet.txt");
  const auto report = test::read_json(folder / "out/report.json");
  EXPECT_TRUE(report.at("same_map").get<bool>());
  for (const auto& robot : report.at("robots")) {
    EXPECT_EQ(robot.at("map_digest"), report.at("robots").at(0).at("map_digest"));
    EXPECT_GT(robot.at("bytes_received").get<std::uint64_t>(), 10000u);
  }
  for (const char* robot : {"robot1", "robot2", "robot3"}) {
    const std::string out = folder / ("out/" + std::string(robot));
    EXPECT_THAT(test::text_of(out + "/log.txt"), HasSubstr("team key "));
    EXPECT_EQ(test::lines(out + "/known_robots"), 2u) << robot;
    struct stat found {};
    ASSERT_EQ(stat((out + "/identity").c_str(), &found), 0);
    EXPECT_EQ(found.st_mode & 0777u, 0600u);
  }
}

TEST(KeyedTeam, WhoHasAnotherKeyOrNoneIsNotHeard) {
  const TempFolder folder;
  const std::string key = test::team_key(folder), other = test::team_key(folder, "other.key", '6');
  const auto a_port = test::free_port(), b_port = test::free_port(), c_port = test::free_port();
  test::Robot a(folder, "a", std::string(kWalk) + "1",
                {"--team-key", key, "--listen", at(a_port), "--peer", at(b_port), "--peer", at(c_port)});
  test::Robot b(folder, "b", std::string(kWalk) + "2",
                {"--team-key", other, "--listen", at(b_port), "--peer", at(a_port)});
  test::Robot c(folder, "c", std::string(kWalk) + "2",
                {"--team-key", "none", "--listen", at(c_port), "--peer", at(a_port)});
  const auto refused = [](const test::Robot& robot, const char* reason) {
    const auto status = robot.status();
    return status.is_object() && status.value("refused", nlohmann::json::object()).value(reason, 0) > 1;
  };
  EXPECT_TRUE(test::wait_until([&] { return refused(a, "bad_mac") && refused(a, "not_sealed"); }, 60s)) << a.log();
  EXPECT_TRUE(test::wait_until([&] { return refused(c, "bad_version"); }, 60s)) << c.log();
  EXPECT_THAT(c.log(), HasSubstr("no team key: this robot talks to this machine only"));
  EXPECT_THAT(a.log(), Not(HasSubstr("is heard")));
  for (test::Robot* robot : {&a, &b, &c}) EXPECT_EQ(robot->stop(), 0) << robot->log();
}

// The name stays with the key that had it first.
TEST(KeyedTeam, ARobotWhoseIdentityWasLostIsRefusedByNameAndPeopleAreTold) {
  const TempFolder folder;
  const std::string key = test::team_key(folder);
  const auto a_port = test::free_port(), b_port = test::free_port();
  test::Robot a(folder, "a", std::string(kWalk) + "1",
                {"--team-key", key, "--listen", at(a_port), "--peer", at(b_port)});
  const std::vector<std::string> options{"--team-key", key, "--listen", at(b_port), "--peer", at(a_port)};
  {
    test::Robot b(folder, "b", std::string(kWalk) + "2", options);
    EXPECT_TRUE(a.says("neighbour b at " + at(b_port) + " is heard", 60s)) << a.log() << b.log();
    EXPECT_EQ(b.stop(), 0) << b.log();
  }
  std::filesystem::remove(folder / "b/identity");
  test::Robot b(folder, "b", std::string(kWalk) + "2", options);
  EXPECT_TRUE(a.says("shows another key than the robot of that name", 60s)) << a.log() << b.log();
  EXPECT_THAT(a.log(), HasSubstr(folder / "a/known_robots"));
  for (test::Robot* robot : {&a, &b}) EXPECT_EQ(robot->stop(), 0) << robot->log();
}

std::string refusal(const TempFolder& folder, const std::vector<std::string>& more, int expected) {
  std::vector<std::string> arguments{"--camera", "simulated:office?frames=5", "--out", folder / "out", "--id", "r"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  EXPECT_EQ(test::run("onemapd", arguments, folder / "said.txt"), expected) << test::text_of(folder / "said.txt");
  return test::text_of(folder / "said.txt");
}

TEST(KeyedTeam, WithoutAKeyOtherMachinesAreRefusedAtTheStart) {
  const TempFolder folder;
  EXPECT_THAT(refusal(folder, {"--team-key", "none", "--peer", "10.0.0.2:4600"}, 2),
              testing::AllOf(HasSubstr("10.0.0.2:4600"), HasSubstr("onemapctl team init")));
  folder.write("g.toml", "[network]\ngroup = \"239.77.1.1:4600\"\n[team]\nkey_file = \"none\"\n");
  EXPECT_THAT(refusal(folder, {"--config", folder / "g.toml"}, 2), HasSubstr("onemapctl team init"));
}

TEST(KeyedTeam, AKeyThatOthersCanReadIsRefusedWithWhatToDo) {
  const TempFolder folder;
  const std::string key = test::team_key(folder);
  std::filesystem::permissions(key, std::filesystem::perms::group_read, std::filesystem::perm_options::add);
  EXPECT_THAT(refusal(folder, {"--team-key", key, "--listen", "127.0.0.1:0"}, 2),
              HasSubstr("others may use it (mode 0640): chmod 600 " + key));
  folder.write("nonsense.key", "hello\n");
  std::filesystem::permissions(folder / "nonsense.key", std::filesystem::perms::owner_read);
  EXPECT_THAT(refusal(folder, {"--team-key", folder / "nonsense.key", "--listen", "127.0.0.1:0"}, 2),
              HasSubstr("expected one line: onemap-team-key-1"));
}

// A service manager tries a start again for ever, but not after 2: nobody but a person mends a file of keys.
TEST(KeyedTeam, KeysThatCannotBeUsedEndTheStartForGood) {
  const TempFolder folder;
  EXPECT_THAT(refusal(folder, {"--team-key", folder / "none.key", "--check-config"}, 2), HasSubstr("team join"));
  EXPECT_THAT(refusal(folder, {"--team-key", folder / "none.key"}, 2), HasSubstr("none.key: cannot be opened"));
  const std::string key = test::team_key(folder);
  const std::vector<std::string> team{"--team-key", key, "--listen", "127.0.0.1:0"};
  folder.write("out/known_robots", "bert\n");
  EXPECT_THAT(refusal(folder, team, 2), HasSubstr("known_robots:1: expected a robot's name and its key"));
  folder.write("out/identity", "spoilt\n");
  std::filesystem::permissions(folder / "out/identity", std::filesystem::perms::owner_read);
  EXPECT_THAT(refusal(folder, team, 2), HasSubstr("identity: is not a robot's key"));
  EXPECT_EQ(test::text_of(folder / "out/identity"), "spoilt\n") << "left for whoever can mend it";
}

}  // namespace
}  // namespace onemap
