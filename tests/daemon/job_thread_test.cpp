#include "daemon/job_thread.hpp"

#include <gtest/gtest.h>

#include <future>

namespace onemap::daemon {
namespace {

TEST(JobThread, DoesOneAfterAnotherRefusesTooManyAndLeavesTheRestOutAtTheEnd) {
  std::atomic<int> done = 0;
  std::promise<void> begun, go_on;
  auto may_go_on = go_on.get_future();
  {
    JobThread jobs("jobs");
    ASSERT_TRUE(jobs.post([&](const auto&) {
      begun.set_value();
      may_go_on.wait();
      ++done;
    }));
    begun.get_future().wait();
    for (std::size_t i = 0; i < JobThread::kWaiting; ++i) ASSERT_TRUE(jobs.post([&](const auto&) { ++done; }));
    EXPECT_FALSE(jobs.post([&](const auto&) { ++done; })) << "nobody waits for room";
    std::promise<void> stopping;
    std::thread stops([&] {
      stopping.set_value();
      jobs.stop();
    });
    stopping.get_future().wait();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    go_on.set_value();
    stops.join();
    EXPECT_FALSE(jobs.post([&](const auto&) { ++done; }));
  }
  EXPECT_EQ(done, 1);
}

TEST(JobThread, DoesWhatItIsGiven) {
  std::promise<bool> done;
  JobThread jobs("jobs");
  ASSERT_TRUE(jobs.post([&](const std::atomic<bool>& stopping) { done.set_value(stopping); }));
  EXPECT_FALSE(done.get_future().get());
}

}  // namespace
}  // namespace onemap::daemon
