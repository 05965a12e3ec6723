#include "daemon/log.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;

// stderr into a file, which JOURNAL_STREAM may name as the journal's.
struct LogTest : testing::Test {
  const test::TempFolder folder;
  int old = dup(STDERR_FILENO);
  LogTest() {
    const int file = open((folder / "err").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(file, STDERR_FILENO);
    close(file);
  }
  ~LogTest() override {
    restore();
    unsetenv("JOURNAL_STREAM");
  }
  void restore() {
    std::fflush(stderr);
    if (old >= 0) dup2(old, STDERR_FILENO), close(std::exchange(old, -1));
  }
  static std::string stream(int more) {
    struct stat at {};
    fstat(STDERR_FILENO, &at);
    return std::to_string(at.st_dev) + ":" + std::to_string(at.st_ino + static_cast<ino_t>(more));
  }
  std::vector<std::string> lines() {
    restore();
    return test::lines_of(folder / "err");
  }
  static void say(Log& log) {
    log.line("changed to {}", 1);
    log.warn("look\n at it");
    log.error("over");
    log.limited("topic", "again");
    log.limited(Level::info, "other", "news");
  }
};

TEST_F(LogTest, IntoTheJournalEveryLineHasItsPriority) {
  setenv("JOURNAL_STREAM", stream(0).c_str(), 1);
  Log log("r1");
  say(log);
  EXPECT_THAT(lines(), testing::ElementsAre("<6>r1: changed to 1", "<4>r1: look\\x0a at it", "<3>r1: over",
                                            "<4>r1: again", "<6>r1: news"));
}

TEST_F(LogTest, AnywhereElseNoneHas) {
  setenv("JOURNAL_STREAM", stream(1).c_str(), 1);  // of somebody who started us with another stderr
  Log log("r1");
  say(log);
  EXPECT_THAT(lines(),
              testing::ElementsAre("r1: changed to 1", "r1: look\\x0a at it", "r1: over", "r1: again", "r1: news"));
}

TEST_F(LogTest, AFloodIsCutAndErrorsAreNot) {
  Log log("r1");
  for (int i = 0; i < 2000; ++i) log.line("flood");
  log.error("over");
  const auto all = lines();
  EXPECT_GE(all.size(), LineBudget::kAtOnce);
  EXPECT_LT(all.size(), 1500u);
  EXPECT_EQ(all.back(), "r1: over");
}

TEST(RepeatBudget, WhatGoesOnIsSaidLessAndLessOften) {
  RepeatBudget budget;
  const Instant begin{};
  std::vector<int> said;
  unsigned left_out = 0, all_left_out = 0;
  for (int s = 0; s < 60; ++s)
    if (budget.take(begin + s * 1s, left_out)) {
      said.push_back(s);
      all_left_out += left_out;
    }
  EXPECT_EQ(said, (std::vector<int>{0, 1, 3, 7, 15, 31, 47}));
  EXPECT_EQ(all_left_out + said.size(), 48u) << "all up to the last line";
  ASSERT_TRUE(budget.take(begin + 120s, left_out));
  EXPECT_TRUE(budget.take(begin + 121s, left_out)) << "after a while without it it is news";
}

TEST(LineBudget, FillsAgainAndSaysWhatWasLeftOut) {
  LineBudget budget;
  unsigned left_out = 0;
  const Instant t{};
  for (int i = 0; i < LineBudget::kAtOnce; ++i) ASSERT_TRUE(budget.take(t, left_out));
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(budget.take(t, left_out));
  EXPECT_TRUE(budget.take(t + 1s, left_out));
  EXPECT_EQ(left_out, 7u);
  for (int i = 0; i < LineBudget::kEverySecond - 1; ++i) ASSERT_TRUE(budget.take(t + 1s, left_out));
  EXPECT_FALSE(budget.take(t + 1s, left_out));
  for (int i = 0; i < LineBudget::kAtOnce; ++i) ASSERT_TRUE(budget.take(t + 24h, left_out)) << "and no further";
  EXPECT_FALSE(budget.take(t + 24h, left_out));
}

}  // namespace
}  // namespace onemap::daemon
