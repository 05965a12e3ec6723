// A robot that comes back to where it was keeps less of it, and who joins it later makes the same map of that.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "daemon/fleet/link_emulator.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::Robot;

// 0 where there is none.
double metric(const test::TempFolder& folder, const Robot& robot, const std::string& name) {
  const auto text = folder / "metrics.txt";
  if (test::run("onemapctl", {"--socket", robot.out() / "control.sock", "metrics"}, text) != 0) return 0;
  for (const std::string& line : test::lines_of(text))
    if (line.starts_with(name + " ")) return std::strtod(line.c_str() + name.size(), nullptr);
  return 0;
}

TEST(Returning, WhoComesLaterMakesTheSameMapOfWhatWasKept) {
  const test::TempFolder folder;
  auto link = daemon::LinkEmulator::open({{0, 1}}, {});
  ASSERT_TRUE(link.ok()) << link.error().text();
  (*link)->start();
  folder.write("team.toml", "[run]\nmerge_while_mapping_s = 1\nmap_interval_s = 0.5\nlinger_s = 0\n");
  const auto robot = [&](std::size_t number, const std::string& name, int frames) {
    return Robot(
        folder, name,
        fmt::format("simulated:living-room?robot={}&robots=2&frames={}&fps=4&width=320&height=240", number + 1, frames),
        {"--speed", "max", "--listen", "127.0.0.1:0", "--config", folder / "team.toml", "--peer",
         fmt::format("127.0.0.1:{}", (*link)->port(0, number))});
  };
  Robot walker = robot(0, "walker", 480);
  const auto has_let_go = [&] {
    return walker.status("frames", 0) == 480 && metric(folder, walker, "onemap_keyframes_needless_total") > 0 &&
           metric(folder, walker, "onemap_submaps_needless_total") > 0 &&
           metric(folder, walker, "onemap_bodies_let_go_total") > 0;
  };
  ASSERT_TRUE(test::wait_until(has_let_go, 200s)) << walker.log();

  Robot late = robot(1, "late", 20);
  const auto agree = [&] {
    const auto digest = walker.status("map_digest", std::string());
    return walker.status("map_agreed", false) && late.status("map_agreed", false) && !digest.empty() &&
           late.status("map_digest", std::string()) == digest && late.status("robots_known", 0) == 2;
  };
  ASSERT_TRUE(test::wait_until(agree, 100s)) << walker.log() << late.log();
  for (const char* kind : {"keyframe", "submap"}) {
    const auto bytes = fmt::format("onemap_record_bytes_total{{robot=\"walker\",kind=\"{}\"}}", kind);
    EXPECT_GT(metric(folder, late, bytes), 0) << kind;
    EXPECT_LT(metric(folder, late, bytes), metric(folder, walker, bytes)) << kind << ": heads came in place of bodies";
  }
  EXPECT_EQ(walker.stop(), 0) << walker.log();
  EXPECT_EQ(late.stop(), 0) << late.log();
}

}  // namespace
}  // namespace onemap
