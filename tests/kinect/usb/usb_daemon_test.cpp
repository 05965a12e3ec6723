// onemapd on a machine that umockdev plays: a V4L2 camera gives it frames, and others come to its USB, leave, are reset
// and are on slow ports, which its log says.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/v4l2/mock_machine.hpp"
#include "plain_bus.hpp"
#include "support/running.hpp"

namespace onemap {
namespace {

using namespace std::chrono_literals;
using test::device_of;
using testing::HasSubstr;

constexpr int kRealSense = 0x8086;

// A daemon that maps, and the USB beside it.
class UsbDaemon : public testing::Test {
 protected:
  UsbDaemon() {
    folder_.write("registered.txt", test::kRegistered);
    camera_.plug(0);
    robot_.emplace(folder_, "r", "v4l2:?calibration=" + (folder_ / "registered.txt"), std::vector<std::string>{});
  }
  void SetUp() override { ASSERT_TRUE(goes_on()) << robot_->log(); }
  void TearDown() override {
    EXPECT_TRUE(goes_on()) << robot_->log();
    EXPECT_EQ(robot_->stop(), 0) << robot_->log();
  }
  bool goes_on() {
    const auto before = robot_->status("frames", std::uint64_t{0});
    return test::wait_until([&] { return robot_->status("frames", std::uint64_t{0}) > before; }, 60s);
  }
  std::size_t lines_with(const std::string& words) {
    const auto lines = test::lines_of(folder_ / "r.log");
    return static_cast<std::size_t>(
        std::ranges::count_if(lines, [&](const std::string& line) { return line.find(words) != std::string::npos; }));
  }

  test::TempFolder folder_;
  test::MockTestbed testbed_;
  test::MockUvc camera_{testbed_, 1, "8086:0b07", "Mock depth camera", test::depth_node(), test::colour_node()};
  test::PlainBus bus_{testbed_.handle()};
  std::optional<test::Robot> robot_;
};

TEST_F(UsbDaemon, SaysWhichCamerasComeLeaveAreResetAndAreOnSlowPorts) {
  const auto d455 = device_of(kRealSense, 0x0b5c, 0x0320);
  bus_.plug(3, "5000", d455);
  ASSERT_TRUE(robot_->says("Intel RealSense 8086:0b5c, USB bus 1 port 3 came\n")) << robot_->log();
  bus_.unplug(3);
  ASSERT_TRUE(robot_->says("Intel RealSense 8086:0b5c, USB bus 1 port 3 left\n")) << robot_->log();
  bus_.plug(3, "5000", d455);
  ASSERT_TRUE(robot_->says("Intel RealSense 8086:0b5c, USB bus 1 port 3 was reset\n")) << robot_->log();
  bus_.plug(4, "480", device_of(kRealSense, 0x0b3a, 0x0210));
  ASSERT_TRUE(
      robot_->says("Intel RealSense 8086:0b3a, USB bus 1 port 4 came; it is on USB 2 (480 Mbit/s), where it has "
                   "fewer sizes and frame rates than on USB 3: another port or cable changes that\n"))
      << robot_->log();
  bus_.plug(5, "12");
  ASSERT_TRUE(
      robot_->says("Kinect v1 045e:02ae, USB bus 1 port 5 came; it runs at 12 Mbit/s; it needs a USB 2 port "
                   "with 480 Mbit/s\n"))
      << robot_->log();
  bus_.plug(6, "480", device_of(0x046d, 0x0825, 0x0200));  // somebody's webcam
  bus_.plug(7, "480", device_of(0x2bc5, 0x0669, 0x0200));
  ASSERT_TRUE(robot_->says("Orbbec 2bc5:0669, USB bus 1 port 7 came\n")) << robot_->log();
  EXPECT_EQ(lines_with("046d"), 0u) << robot_->log();
}

// A plug that is loose: the log says so, and is not full of it.
TEST_F(UsbDaemon, ResetsWithoutEndFillNoLog) {
  const auto d455 = device_of(kRealSense, 0x0b5c, 0x0320);
  bus_.plug(3, "5000", d455);
  for (int i = 0; i < 30; ++i) {
    bus_.unplug(3);
    bus_.plug(3, "5000", d455);
    bus_.plug(10 + i, "480", device_of(0x2bc5, 0x0669, 0x0200));  // it has heard of this one: and of those before
    ASSERT_TRUE(robot_->says(fmt::format("port {} came\n", 10 + i))) << robot_->log();
  }
  EXPECT_TRUE(robot_->says("port 3 was reset\n")) << robot_->log();
  EXPECT_TRUE(goes_on()) << robot_->log();
  EXPECT_LT(lines_with("8086:0b5c, USB bus 1 port 3 "), 20u) << robot_->log();
}

}  // namespace
}  // namespace onemap
