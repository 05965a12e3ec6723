// Teams of real daemons over emulated links: lines, rings, stars and meshes, through kill -9, SIGSTOP and links that
// come and go. They take minutes, so all but one are for `./check net` (ONEMAP_NET in the environment).
#include "net_team.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace onemap {
namespace {

using namespace std::chrono_literals;
using comms::sim::Edge;
using test::LinkTraits;
using test::NetTeam;

LinkTraits lossy(double loss) {
  LinkTraits traits;
  traits.loss = loss;
  traits.jitter = 2ms;
  return traits;
}

bool wait_until(const std::function<bool()>& done, std::chrono::milliseconds limit) {
  const auto end = std::chrono::steady_clock::now() + test::kPatience * limit;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(50ms);
  }
  return true;
}

#define NEEDS_MINUTES() \
  if (std::getenv("ONEMAP_NET") == nullptr) GTEST_SKIP() << "takes minutes: ./check net"
#define NEEDS_NAMESPACES(team) \
  if (!(team).missing().empty()) GTEST_SKIP() << (team).missing()

void expect_equal(NetTeam& team, std::chrono::seconds limit) {
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(wait_until([&] { return team.equal(); }, limit)) << team.words() << team.log(0);
  std::printf("equal after %.1f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
}

bool all_map(const NetTeam& team) {
  for (std::size_t i = 0; i < team.size(); ++i)
    if (team.keyframes(i) < 2) return false;
  return true;
}

TEST(Net, ALineOfThreeEndsEqual) {
  NetTeam team(3, comms::sim::line(3), lossy(0.05), 30);
  NEEDS_NAMESPACES(team);
  expect_equal(team, 120s);
}

TEST(Net, ALineWhoseMiddleIsKilledEndsEqual) {
  NEEDS_MINUTES();
  NetTeam team(4, comms::sim::line(4), lossy(0.1), 60);
  NEEDS_NAMESPACES(team);
  ASSERT_TRUE(wait_until([&] { return all_map(team); }, 120s)) << team.words();
  for (int k = 0; k < 3; ++k) {
    team.end(1, SIGKILL);
    std::this_thread::sleep_for(500ms + 370ms * k);
    team.start(1);
    std::this_thread::sleep_for(2s);
  }
  expect_equal(team, 240s);
}

TEST(Net, ARingWhoseLinksFlapEndsEqual) {
  NEEDS_MINUTES();
  const auto edges = comms::sim::ring(5);
  NetTeam team(5, edges, lossy(0.05), 60);
  NEEDS_NAMESPACES(team);
  ASSERT_TRUE(wait_until([&] { return all_map(team); }, 180s)) << team.words();
  for (std::size_t k = 0; k < 30;
       ++k) {  // two links are down at any time, so that the ring falls apart again and again
    team.net().set_up(k % edges.size(), false);
    team.net().set_up((k + 2) % edges.size(), false);
    std::this_thread::sleep_for(300ms);
    team.net().set_up(k % edges.size(), true);
    if (k % 3 == 0) team.net().set_up((k + 2) % edges.size(), true);
  }
  for (std::size_t link = 0; link < edges.size(); ++link) team.net().set_up(link, true);
  expect_equal(team, 240s);
}

TEST(Net, AStarWhoseHubStopsEndsEqual) {
  NEEDS_MINUTES();
  NetTeam team(5, comms::sim::star(5), lossy(0.05), 60);
  NEEDS_NAMESPACES(team);
  ASSERT_TRUE(wait_until([&] { return all_map(team); }, 180s)) << team.words();
  for (const auto stopped : {1s, 6s, 12s}) {
    team.signal(0, SIGSTOP);
    std::this_thread::sleep_for(stopped);
    team.signal(0, SIGCONT);
    std::this_thread::sleep_for(1s);
  }
  expect_equal(team, 240s);
}

TEST(Net, AMeshOfTenEndsEqual) {
  NEEDS_MINUTES();
  test::Random random(3);
  NetTeam team(10, comms::sim::connected(10, 8, random), lossy(0.05), 40);
  NEEDS_NAMESPACES(team);
  ASSERT_TRUE(wait_until([&] { return all_map(team); }, 300s)) << team.words();
  team.end(3, SIGKILL);
  team.signal(5, SIGSTOP);
  std::this_thread::sleep_for(3s);
  team.start(3);
  team.signal(5, SIGCONT);
  expect_equal(team, 600s);
}

}  // namespace
}  // namespace onemap
