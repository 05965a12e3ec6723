#include "daemon/identity_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

TEST(IdentityFile, IsMadeOnceAndStays) {
  const test::TempFolder folder;
  const auto first = open_identity(folder / "identity");
  ASSERT_TRUE(first.ok()) << first.error().text();
  struct stat entry {};
  ASSERT_EQ(::stat((folder / "identity").c_str(), &entry), 0);
  EXPECT_EQ(entry.st_mode & 0777, 0600u);
  EXPECT_EQ(open_identity(folder / "identity")->public_key(), first->public_key());
  EXPECT_NE(open_identity(folder / "another")->public_key(), first->public_key());
  EXPECT_NE(passing_identity().public_key(), passing_identity().public_key());
}

TEST(IdentityFile, WhatIsNoKeyIsLeftAsItIs) {
  const test::TempFolder folder;
  for (const std::string& text : {std::string(), std::string("hello\n"), std::string(64, 'g') + "\n",
                                  std::string(63, 'a') + "\n", std::string(64, 'a'), std::string(64, 'A') + "\n"}) {
    folder.write("identity", text);
    ::chmod((folder / "identity").c_str(), 0600);
    const auto opened = open_identity(folder / "identity");
    ASSERT_FALSE(opened.ok()) << text;
    EXPECT_THAT(opened.error().text(), testing::HasSubstr("identity"));
    EXPECT_THAT(opened.error().text(), testing::HasSubstr("not a robot's key"));
    EXPECT_EQ(test::text_of(folder / "identity"), text);
  }
}

TEST(IdentityFile, OthersMustNotReadIt) {
  const test::TempFolder folder;
  ASSERT_TRUE(open_identity(folder / "identity").ok());
  ::chmod((folder / "identity").c_str(), 0640);
  const auto opened = open_identity(folder / "identity");
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().text(), testing::HasSubstr("chmod 600"));
}

TEST(IdentityFile, AFolderThatCannotBeWrittenIsAnError) {
  const auto opened = open_identity("/nonexistent/identity");
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().text(), testing::HasSubstr("No such file"));
}

}  // namespace
}  // namespace onemap::daemon
