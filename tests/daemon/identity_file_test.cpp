#include "daemon/identity_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/program.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;

TEST(IdentityFile, IsMadeOnceAndStays) {
  const TempFolder folder, another;
  Log log("r1");
  const auto first = open_identity(folder.path().string(), log);
  ASSERT_TRUE(first.ok()) << first.error().text();
  struct stat entry {};
  ASSERT_EQ(::stat((folder / "identity").c_str(), &entry), 0);
  EXPECT_EQ(entry.st_mode & 0777, 0600u);
  EXPECT_EQ(open_identity(folder.path().string(), log)->public_key(), first->public_key());
  EXPECT_NE(open_identity(another.path().string(), log)->public_key(), first->public_key());
}

TEST(IdentityFile, WhatIsNoKeyIsLeftAsItIs) {
  const TempFolder folder;
  Log log("r1");
  folder.write("identity", "hello\n");
  ::chmod((folder / "identity").c_str(), 0600);
  const auto opened = open_identity(folder.path().string(), log);
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().text(), testing::HasSubstr("take this robot for another one"));
  EXPECT_EQ(test::text_of(folder / "identity"), "hello\n");
}

TEST(IdentityFile, WhoCanKeepNothingHasAKeyForThisLife) {
  Log log("r1");
  const auto one = open_identity("/nonexistent/place", log), two = open_identity("/nonexistent/place", log);
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_NE(one->public_key(), two->public_key());
}

}  // namespace
}  // namespace onemap::daemon
