#include "daemon/worker.hpp"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

namespace onemap::daemon {
namespace {

TEST(Worker, AnExceptionIsReportedAndTheEndIsReached) {
  Failures failures;
  std::atomic<bool> ended = false;
  Worker worker;
  worker.start(
      "pipeline", failures, [] { throw std::runtime_error("the map is on fire"); }, [&] { ended = true; });
  worker.join();
  EXPECT_TRUE(ended);
  EXPECT_TRUE(failures.any());
  EXPECT_EQ(failures.first(), "pipeline: the map is on fire");
}

TEST(Worker, TheFirstFailureIsKept) {
  Failures failures;
  for (const char* name : {"radio", "team"}) {
    Worker worker;
    worker.start(name, failures, [] { throw std::bad_alloc(); });
  }
  EXPECT_EQ(failures.first(), "radio: out of memory");
}

TEST(Worker, WhatIsNoExceptionTypeIsReportedToo) {
  Failures failures;
  Worker worker;
  worker.start("team", failures, [] { throw 7; });
  worker.join();
  EXPECT_EQ(failures.first(), "team: an exception of an unknown type");
}

TEST(Worker, AGoodEndIsNoFailure) {
  Failures failures;
  Worker worker;
  worker.start("team", failures, [] {});
  worker.join();
  EXPECT_FALSE(failures.any());
  EXPECT_EQ(failures.first(), "");
}

TEST(Guarded, AnExceptionBecomesAnErrorOfItsPlace) {
  EXPECT_TRUE(guarded("report", [] { return success(); }));
  const Status failed = guarded("report", []() -> Status { throw std::bad_alloc(); });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().text(), "report: out of memory");
}

}  // namespace
}  // namespace onemap::daemon
