#include "daemon/between_turns.hpp"

#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <thread>

namespace onemap::daemon {
namespace {

// A thread that takes turns, each when it is woken.
struct Turning {
  std::mutex mutex;
  std::condition_variable changed;
  bool woken = false, over = false;
  BetweenTurns asked{[this] { wake(); }};
  std::thread thread{[this] { run(); }};
  std::thread::id id = thread.get_id();

  ~Turning() { end(); }
  void wake() {
    const std::lock_guard lock(mutex);
    woken = true;
    changed.notify_all();
  }
  void run() {
    for (std::unique_lock lock(mutex); !over;) {
      changed.wait(lock, [this] { return woken || over; });
      woken = false;
      lock.unlock();
      asked.do_all();
      lock.lock();
    }
    asked.close();
  }
  void end() {
    {
      const std::lock_guard lock(mutex);
      over = true;
      changed.notify_all();
    }
    if (thread.joinable()) thread.join();
  }
};

TEST(BetweenTurns, AreDoneOnThatThreadWhileTheAskersWait) {
  Turning loop;
  const std::atomic<bool> stop = false;
  int done = 0;  // by one thread alone
  std::vector<std::thread> askers;
  for (int k = 0; k < 4; ++k)
    askers.emplace_back([&] {
      for (int i = 0; i < 50; ++i)
        EXPECT_TRUE(loop.asked.run([&] { done += std::this_thread::get_id() == loop.id ? 1 : 1000; }, stop));
    });
  for (std::thread& asker : askers) asker.join();
  EXPECT_EQ(done, 200);
}

TEST(BetweenTurns, WhatAJobThrowsIsItsAskers) {
  Turning loop;
  const std::atomic<bool> stop = false;
  EXPECT_THROW(loop.asked.run([] { throw std::runtime_error("no"); }, stop), std::runtime_error);
  EXPECT_TRUE(loop.asked.run([] {}, stop)) << "the thread goes on";
}

TEST(BetweenTurns, AreLeftOutWhenTheAskerStopsOrTheThreadHasEnded) {
  BetweenTurns asked([] {});  // nobody turns
  std::atomic<bool> stop = true;
  bool done = false;
  EXPECT_FALSE(asked.run([&] { done = true; }, stop));
  asked.do_all();
  EXPECT_FALSE(done) << "its asker is gone";
  stop = false;
  auto waits = std::async(std::launch::async, [&] { return asked.run([&] { done = true; }, stop); });
  asked.close();
  EXPECT_FALSE(waits.get());
  EXPECT_FALSE(asked.run([&] { done = true; }, stop));
  EXPECT_FALSE(done);
}

TEST(BetweenTurns, WhatHasBegunIsWaitedForWhateverTheAskerWants) {
  Turning loop;
  std::atomic<bool> stop = false;
  bool done = false;
  EXPECT_TRUE(loop.asked.run(
      [&] {
        stop = true;
        std::this_thread::sleep_for(std::chrono::milliseconds(120));  // the asker looks meanwhile
        done = true;
      },
      stop));
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace onemap::daemon
