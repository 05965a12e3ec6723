#include "daemon/service.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "support/notify_socket.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr Instant kStart{1000s};

TEST(Heartbeat, IsStuckWhenItNeitherBeatsNorRests) {
  Heartbeat heart("pipeline", 10s);
  EXPECT_FALSE(heart.stuck(kStart)) << "not begun";
  heart.beat(kStart);
  EXPECT_FALSE(heart.stuck(kStart + 10s));
  EXPECT_TRUE(heart.stuck(kStart + 11s));
  heart.rest();
  EXPECT_FALSE(heart.stuck(kStart + 1000s)) << "waits for work";
  heart.beat(kStart + 1000s);
  EXPECT_FALSE(heart.stuck(kStart + 1001s));
}

class ServiceTest : public testing::Test {
 protected:
  std::vector<std::string> said() {
    std::vector<std::string> all;
    while (auto text = socket_.next(0ms)) all.push_back(*text);
    return all;
  }
  // How often the watchdog is fed by looks a second apart; the socket holds only ten.
  std::size_t fed(std::chrono::seconds from, std::chrono::seconds to) {
    std::size_t times = 0;
    for (auto t = from; t <= to; t += 1s) {
      service_.watch(hearts_, kStart + t);
      times += said().size();
    }
    return times;
  }
  const test::TempFolder folder_;
  test::NotifySocket socket_{folder_ / "notify"};
  Log log_{"robot"};
  Service service_{log_, {socket_.name(), "4000000", ""}};
  Heartbeat pipeline_{"pipeline", 10s}, team_{"team", 30s};
  const std::array<const Heartbeat*, 2> hearts_{&pipeline_, &team_};
};

TEST_F(ServiceTest, FeedsTheWatchdogOftenEnoughAndNotMore) {
  for (auto t = 0ms; t < 4000ms; t += 50ms) service_.watch(hearts_, kStart + t);
  EXPECT_EQ(said(), std::vector<std::string>(4, "WATCHDOG=1"));
}

TEST_F(ServiceTest, DoesNotFeedItWhileAThreadIsStuckAndSaysWhich) {
  team_.beat(kStart);
  EXPECT_EQ(fed(0s, 30s), 31u);
  testing::internal::CaptureStderr();
  for (auto t = 31s; t < 60s; t += 1s) service_.watch(hearts_, kStart + t);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "robot: the team thread has not got on for 30 s: the watchdog is not fed, and the service will be started "
            "again\n");
  EXPECT_TRUE(said().empty());
  team_.beat(kStart + 60s);
  testing::internal::CaptureStderr();
  service_.watch(hearts_, kStart + 61s);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("all threads get on again"));
  EXPECT_EQ(said().size(), 1u);
}

TEST_F(ServiceTest, WhoWasStoppedForLongIsNotStuckUnlessItStaysSo) {
  team_.beat(kStart);
  EXPECT_EQ(fed(0s, 0s), 1u);
  testing::internal::CaptureStderr();
  EXPECT_EQ(fed(60s, 90s), 31u);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  EXPECT_EQ(fed(91s, 91s), 0u);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("the team thread has not got on for 30 s"));
}

TEST_F(ServiceTest, ShowsALineWhenItChangedAtMostOnceASecond) {
  DaemonStatus status;
  status.tracking = true;
  for (int i = 0; i < 40; ++i) {
    status.frames = static_cast<std::uint64_t>(i);
    service_.show(status, kStart + i * 50ms);
  }
  EXPECT_EQ(said().size(), 2u);
  service_.show(status, kStart + 60s);
  EXPECT_EQ(said().size(), 1u);
  service_.show(status, kStart + 70s);
  EXPECT_TRUE(said().empty()) << "nothing new";
}

TEST(StatusLine, SaysWhatARobotDoes) {
  DaemonStatus s;
  s.frames = 10;
  EXPECT_EQ(status_line(s), "lost: 0 of 10 frames placed, 0 keyframes; no map yet");
  s.tracking = true;
  s.tracked = 9;
  s.keyframes = 3;
  s.robots_known = 3;
  s.robots_in_map = 2;
  s.map_digest = 0xabc;
  EXPECT_EQ(status_line(s), "tracking: 9 of 10 frames placed, 3 keyframes; 2 of 3 robots in the map 0000000000000abc");
  s.map_differs = {"anna", "bert"};
  EXPECT_THAT(status_line(s), HasSubstr(", not yet held by anna, bert"));
  s.map_agreed = true;
  EXPECT_THAT(status_line(s), HasSubstr(", held by all"));
  s.stuck = true;
  s.waiting = "waits for anna";
  EXPECT_THAT(status_line(s), HasSubstr("; waits for anna"));
}

}  // namespace
}  // namespace onemap::daemon
