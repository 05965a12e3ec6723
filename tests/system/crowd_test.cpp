// A hundred peers: the daemon maps on, its memory stays bounded, and people are answered.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/control_talk.hpp"
#include "support/crowd.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using control::Json;
using test::at;
using test::kSanitized;
using test::Robot;
using test::TempFolder;
using testing::HasSubstr;

constexpr std::size_t kHundred = 100;

// A robot of a room, with its control socket.
struct Host {
  Host(const TempFolder& folder, const std::string& id, int number, std::uint16_t port,
       const std::vector<std::string>& peers)
      : socket(folder / (id + ".sock")) {
    folder.write(id + ".toml",
                 fmt::format("[network]\nlisten = \"{}\"\npeers = [{}]\n[run]\nmerge_while_mapping_s = 1\n[control]\n"
                             "socket = \"{}\"\n",
                             at(port), quoted(peers), socket));
    robot.emplace(
        folder, id,
        fmt::format("simulated:living-room?seed=3&robots=5&frames=100000&width=320&height=240&robot={}", number),
        std::vector<std::string>{"--speed", "0.3", "--config", folder / (id + ".toml")});
  }
  static std::string quoted(const std::vector<std::string>& words) {
    return words.empty() ? "" : fmt::format("\"{}\"", fmt::join(words, "\", \""));
  }
  Json ask(const std::string& name) const {
    test::Talk talk(socket);
    talk.ask(fmt::format(R"({{"class":"{}"}})", name));
    Json answer = talk.hear_class(name);
    return answer.is_object() ? answer : Json::object();
  }
  // It places nearly every frame of the next hundred.
  void expect_to_track() {
    // A daemon speaks to its peers before its camera is open, and writes its first status after that.
    ASSERT_TRUE(test::wait_until([&] { return robot->status().is_object(); }, 60s)) << robot->log();
    const auto first = robot->status();
    ASSERT_TRUE(first.is_object());
    const auto after = [&](const char* key) { return robot->status(key, 0) - first.value(key, 0); };
    EXPECT_TRUE(test::wait_until([&] { return after("frames") >= 100; }, 120s)) << robot->log();
    EXPECT_GE(after("tracked"), 90) << robot->log();
  }
  const std::string socket;
  std::optional<Robot> robot;
};

TEST(HundredPeers, WhoAllSpeakAreInOneTeam) {
  const TempFolder folder;
  const auto port = test::free_port();
  test::Crowd crowd(kHundred, port);
  Host host(folder, "host", 1, port, crowd.addresses());
  ASSERT_TRUE(host.robot->says("listening at")) << host.robot->log();
  crowd.start();
  const auto joined = [&] { return host.robot->status("robots_known", std::size_t{0}) == kHundred + 1; };
  EXPECT_TRUE(test::wait_until(joined, 120s)) << host.robot->log();
  EXPECT_TRUE(test::wait_until([&] { return crowd.fewest_known() == kHundred + 1; }, 120s))
      << "each hears of all the others, over the daemon: " << crowd.fewest_known();
  host.expect_to_track();
  EXPECT_EQ(host.ask("PEERS").at("peers").size(), kHundred);
  EXPECT_THAT(host.ask("METRICS").value("text", ""), HasSubstr("onemap_peer_bytes_total"));
  const double most_mb = host.robot->memory_mb();
  fmt::print("a hundred peers that speak: {:.0f} MB at most\n", most_mb);
  EXPECT_LT(most_mb, kSanitized ? 2000 : 400);
  EXPECT_EQ(host.robot->stop(), 0) << host.robot->log();
}

TEST(HundredPeers, WhomNobodyConfiguredHaveTheTablesPlacesAndNoMore) {
  const TempFolder folder;
  const auto port = test::free_port();
  test::Crowd crowd(kHundred, port);
  Host host(folder, "host", 1, port, {});
  ASSERT_TRUE(host.robot->says("listening at")) << host.robot->log();
  crowd.start();
  const std::size_t places = comms::NodeConfig().max_neighbours;
  EXPECT_TRUE(test::wait_until([&] { return crowd.answered() == places; }, 60s)) << crowd.answered();
  host.expect_to_track();
  EXPECT_LE(host.ask("PEERS").at("peers").size(), places);
  EXPECT_LT(host.robot->memory_mb(), kSanitized ? 2000 : 400);
  EXPECT_EQ(host.robot->stop(), 0) << host.robot->log();
}

TEST(HundredPeers, OfWhomNearlyAllAreDeadCostNextToNothing) {
  const TempFolder folder;
  const auto port = test::free_port(), living = test::free_port();
  std::vector<std::string> peers;
  for (std::size_t i = 1; i < kHundred; ++i) peers.push_back(at(test::free_port()));
  const std::string dead = peers.front();
  peers.push_back(at(living));
  Host host(folder, "host", 1, port, peers);
  Host other(folder, "other", 2, living, {at(port)});
  const auto one_map = [](const Host& h) {
    return h.robot->status("map_agreed", false) && h.robot->status("robots_in_map", 0) == 2;
  };
  EXPECT_TRUE(test::wait_until([&] { return one_map(host) && one_map(other); }, 150s))
      << host.robot->log() << other.robot->log();
  host.expect_to_track();
  EXPECT_THAT(host.ask("DOCTOR").dump(), HasSubstr("peer " + dead + " was never heard"));
  EXPECT_LT(host.robot->memory_mb(), kSanitized ? 2000 : 400);
  EXPECT_EQ(host.robot->stop(), 0) << host.robot->log();
  EXPECT_EQ(other.robot->stop(), 0) << other.robot->log();
}

}  // namespace
}  // namespace onemap
