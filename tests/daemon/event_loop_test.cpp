#include "daemon/event_loop.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "daemon/feed.hpp"
#include "daemon/signals.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;

struct Pair {
  int ends[2] = {-1, -1};
  Pair() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0); }
  ~Pair() {
    for (const int end : ends) close(end);
  }
};

struct EventLoopTest : testing::Test {
  std::unique_ptr<EventLoop> loop = EventLoop::open().value();
};

TEST_F(EventLoopTest, TellsWhatIsReadyAndStopsWhenAsked) {
  Pair pair;
  std::string got;
  ASSERT_TRUE(loop->watch(pair.ends[0], EventLoop::kReadable, [&](std::uint32_t events) {
    EXPECT_TRUE(events & EventLoop::kReadable);
    char c = 0;
    if (read(pair.ends[0], &c, 1) == 1) got += c;
    if (got == "ab") loop->stop();
  }));
  ASSERT_EQ(write(pair.ends[1], "ab", 2), 2);
  loop->run();
  EXPECT_EQ(got, "ab") << "level triggered: the second byte was there all the time";
}

TEST_F(EventLoopTest, ACallbackMayForgetItselfAndTheOthersOfItsTurn) {
  Pair a, b;
  int calls = 0;
  EventLoop::Id first = 0, second = 0;
  const auto forget_both = [&](std::uint32_t) {
    ++calls;
    loop->forget(first);
    loop->forget(second);
  };
  first = *loop->watch(a.ends[0], EventLoop::kReadable, forget_both);
  second = *loop->watch(b.ends[0], EventLoop::kReadable, forget_both);
  ASSERT_EQ(write(a.ends[1], "x", 1) + write(b.ends[1], "x", 1), 2);
  ASSERT_TRUE(loop->every(20ms, [&] { loop->stop(); }));
  loop->run();
  EXPECT_EQ(calls, 1);
}

TEST_F(EventLoopTest, ChangesWhatItWaitsFor) {
  Pair pair;
  int writable = 0;
  const auto id = loop->watch(pair.ends[0], EventLoop::kReadable, [&](std::uint32_t events) {
    if (events & EventLoop::kWritable) ++writable;
    loop->stop();
  });
  ASSERT_TRUE(id);
  loop->change(*id, EventLoop::kWritable);
  loop->run();
  EXPECT_EQ(writable, 1);
}

TEST_F(EventLoopTest, TicksThatWereMissedAreOne) {
  int ticks = 0;
  ASSERT_TRUE(loop->every(10ms, [&] {
    if (++ticks == 1) std::this_thread::sleep_for(100ms);  // ten of them, as after SIGCONT
  }));
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(loop->every(150ms, [&] { loop->stop(); }));
  loop->run();
  const auto most = (std::chrono::steady_clock::now() - began - 100ms) / 10ms + 2;
  EXPECT_GE(ticks, 2);
  EXPECT_LE(ticks, most);
}

TEST_F(EventLoopTest, OtherThreadsHandInTasks) {
  std::thread::id ran_on;
  std::thread other([&] {
    loop->post([&] {
      ran_on = std::this_thread::get_id();
      loop->stop();
    });
  });
  loop->run();
  other.join();
  EXPECT_EQ(ran_on, std::this_thread::get_id());
}

TEST_F(EventLoopTest, ADescriptorThatCannotBeWatchedIsAnError) {
  EXPECT_FALSE(loop->watch(-1, EventLoop::kReadable, [](std::uint32_t) {}).ok());
}

TEST_F(EventLoopTest, SignalsComeThroughIt) {
  StopSignals signals(Hangup::reloads);
  std::vector<int> got;
  ASSERT_TRUE(loop->watch(signals.descriptor(), EventLoop::kReadable, [&](std::uint32_t) {
    while (const auto signal = signals.take()) got.push_back(*signal);
    if (got.size() == 2) loop->stop();
  }));
  pthread_kill(pthread_self(), SIGHUP);
  pthread_kill(pthread_self(), SIGTERM);
  loop->run();
  EXPECT_EQ(got, (std::vector<int>{SIGHUP, SIGTERM}));
}

TEST(Feed, RingsOnceAndTheOldestMakesRoom) {
  int rung = 0;
  Feed<int> feed(3, [&] { ++rung; });
  for (int i = 1; i <= 5; ++i) feed.give(i);
  EXPECT_EQ(rung, 1);
  EXPECT_EQ(feed.dropped(), 2u);
  EXPECT_EQ(feed.take(), (std::vector<int>{3, 4, 5}));
  EXPECT_TRUE(feed.take().empty());
  feed.give(6);
  EXPECT_EQ(rung, 2);
}

}  // namespace
}  // namespace onemap::daemon
