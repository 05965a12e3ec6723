#include "daemon/control/listener.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/control_talk.hpp"
#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using testing::HasSubstr;

TEST(Listener, ALeftOverSocketIsReplacedAndALivingOneIsNot) {
  const test::TempFolder folder;
  const std::string path = folder / "sub/control.sock";
  {
    auto first = Listener::at_path(path);
    ASSERT_TRUE(first.ok()) << first.error().text();
    const auto second = Listener::at_path(path);
    ASSERT_FALSE(second.ok());
    EXPECT_THAT(second.error().text(), HasSubstr("in use by another daemon"));
    std::filesystem::create_hard_link(path, folder / "kept");
  }
  EXPECT_FALSE(std::filesystem::exists(path)) << "taken away at the end";
  std::filesystem::rename(folder / "kept", path);  // as after a kill
  ASSERT_LT(test::connect_to(path), 0);
  const auto again = Listener::at_path(path);
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_TRUE(test::Talk(path).connected());
}

TEST(Listener, WhatIsNoSocketIsNeverTakenAway) {
  const test::TempFolder folder;
  folder.write("file", "mine");
  EXPECT_FALSE(Listener::at_path(folder / "file").ok());
  EXPECT_TRUE(std::filesystem::is_regular_file(folder / "file"));
  const auto below = Listener::at_path(folder / "file/control.sock");
  ASSERT_FALSE(below.ok());
  const auto deep = Listener::at_path(folder / "none/none/control.sock");
  ASSERT_FALSE(deep.ok());
  EXPECT_THAT(deep.error().text(), HasSubstr("cannot make the folder"));
  const auto longer = Listener::at_path(folder / std::string(120, 'x'));
  ASSERT_FALSE(longer.ok());
  EXPECT_THAT(longer.error().text(), HasSubstr("107 bytes"));
}

TEST(Listener, ASocketThatSomebodyElsePutThereStays) {
  const test::TempFolder folder;
  const std::string path = folder / "control.sock";
  auto first = Listener::at_path(path);
  ASSERT_TRUE(first.ok());
  std::filesystem::remove(path);
  auto second = Listener::at_path(path);
  ASSERT_TRUE(second.ok());
  { const Listener gone = std::move(*first); }
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(Listener, KnowsWhoCalls) {
  const test::TempFolder folder;
  auto listener = Listener::at_path(folder / "s");
  ASSERT_TRUE(listener.ok());
  const test::Talk talk(folder / "s");
  int connection = -1;
  ASSERT_EQ(listener->accept(connection), Listener::Got::connection);
  const Caller caller = caller_of(connection, *listener);
  close(connection);
  EXPECT_TRUE(caller.may_change);
  EXPECT_EQ(caller.name, "pid " + std::to_string(getpid()) + ", uid " + std::to_string(geteuid()));
  EXPECT_EQ(listener->accept(connection), Listener::Got::nothing);
}

TEST(Listener, TcpIsOfLoopbackAlone) {
  for (const char* wrong : {"0.0.0.0:4680", "192.168.1.1:4680", "[::]:4680", "localhost:4680", "4680", "127.0.0.1"})
    EXPECT_FALSE(check_loopback(wrong).ok()) << wrong;
  EXPECT_TRUE(check_loopback("127.0.0.1:4680").ok());
  EXPECT_TRUE(check_loopback("[::1]:4680").ok());
  EXPECT_THAT(check_loopback("10.0.0.1:1").error().text(), HasSubstr("not an address of loopback"));
  auto listener = Listener::at_loopback("127.0.0.1:0");
  ASSERT_TRUE(listener.ok()) << listener.error().text();
  EXPECT_THAT(listener->place(), testing::MatchesRegex("127.0.0.1:[0-9]+"));
  EXPECT_FALSE(listener->place().ends_with(":0"));
  EXPECT_FALSE(Listener::at_loopback(listener->place()).ok()) << "taken";
}

}  // namespace
}  // namespace onemap::daemon
