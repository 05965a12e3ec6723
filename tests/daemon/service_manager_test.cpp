#include "daemon/service_manager.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "support/notify_socket.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class ServiceManagerTest : public testing::TestWithParam<bool> {
 protected:
  const test::TempFolder folder_;
  test::NotifySocket socket_{GetParam() ? fmt::format("@onemap-test-{}", ::getpid()) : folder_ / "notify"};
};

TEST_P(ServiceManagerTest, SaysWhatSdNotifyWouldSay) {
  ServiceManager manager({socket_.name(), "", ""});
  ASSERT_TRUE(manager.present());
  const auto said = [this](const Status& sent) {
    EXPECT_TRUE(sent.ok());
    return socket_.next(1s).value_or("nothing");
  };
  EXPECT_EQ(said(manager.ready()), "READY=1");
  EXPECT_EQ(said(manager.alive()), "WATCHDOG=1");
  EXPECT_EQ(said(manager.stopping()), "STOPPING=1");
  EXPECT_EQ(said(manager.reloading(Instant(1500us))), "RELOADING=1\nMONOTONIC_USEC=1500");
  EXPECT_EQ(said(manager.say("two robots")), "STATUS=two robots");
  EXPECT_EQ(said(manager.say("x\nREADY=1")), "STATUS=x\\x0aREADY=1") << "no message within a message";
}
INSTANTIATE_TEST_SUITE_P(PathAndAbstract, ServiceManagerTest, testing::Bool());

TEST(ServiceManager, WithoutASocketEverythingIsQuietlyDone) {
  ServiceManager manager({});
  EXPECT_FALSE(manager.present());
  EXPECT_TRUE(manager.ready().ok());
  EXPECT_FALSE(manager.watchdog());
}

TEST(ServiceManager, ASocketThatIsNotThereIsAnError) {
  for (const std::string& name : std::vector<std::string>{"/nonexistent/notify", "vsock:2:1", std::string(200, '/')}) {
    ServiceManager manager({name, "", ""});
    const Status sent = manager.ready();
    ASSERT_FALSE(sent.ok()) << name;
    EXPECT_EQ(sent.error().place, "NOTIFY_SOCKET");
  }
}

TEST(ServiceManager, IsWatchedOnlyWhereTheWatchdogIsMeantForIt) {
  const auto watchdog = [](const std::string& us, const std::string& pid) {
    return ServiceManager({"@x", us, pid}).watchdog();
  };
  EXPECT_EQ(watchdog("3000000", ""), 3s);
  EXPECT_EQ(watchdog("3000000", std::to_string(::getpid())), 3s);
  EXPECT_FALSE(watchdog("3000000", "1"));
  EXPECT_FALSE(watchdog("", ""));
  EXPECT_FALSE(watchdog("soon", ""));
  EXPECT_FALSE(watchdog("-5", ""));
}

}  // namespace
}  // namespace onemap::daemon
