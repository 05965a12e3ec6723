// What the v4l2 backend finds on machines that umockdev plays: what can be used, why not, and what does less than it
// could where it is plugged in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/v4l2/mock_machine.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using test::colour_node;
using test::depth_node;
using test::kGrey;
using test::MockNodeConfig;
using testing::HasSubstr;

class V4l2List : public testing::Test {
 protected:
  void SetUp() override {
    if (!machine_.missing().empty()) GTEST_SKIP() << machine_.missing();
  }
  static MockNodeConfig with_rates(MockNodeConfig node, std::vector<std::uint32_t> rates) {
    node.rates = std::move(rates);
    return node;
  }
  test::Machine machine_;
};

TEST_F(V4l2List, ColourIsFoundOnTheSameDeviceAndGreyIsTheLastChoice) {
  machine_.add(1, 0, depth_node(), colour_node({kGrey}));
  machine_.add(2, 2, colour_node({kGrey}), colour_node());  // a webcam, not of this device
  EXPECT_THAT(list_v4l2(), testing::ElementsAre(testing::Field(&CameraInfo::address, "v4l2:/dev/video0")));
  EXPECT_THAT(list_v4l2()[0].abilities, HasSubstr("colour /dev/video1 GREY 640x480 320x240"));
}

TEST_F(V4l2List, ListSaysWhatIsThereAndWhyOneCannotBeUsed) {
  machine_.add(1, 0, depth_node(), colour_node(), "1234:5678");
  machine_.add(2, 2, depth_node(), colour_node());
  machine_.add(3, 4, depth_node(), depth_node());
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 4u);
  EXPECT_EQ(cameras[0].address, "v4l2:/dev/video2");
  EXPECT_EQ(cameras[0].description, "Mock depth camera S2 (USB 8086:0b07)");
  EXPECT_EQ(cameras[0].problem, "");
  EXPECT_THAT(cameras[0].abilities,
              testing::AllOf(HasSubstr("depth /dev/video2 Z16 640x480 320x240; colour /dev/video3 YUYV"),
                             HasSubstr("nominal for realsense-d435")));
  EXPECT_THAT(cameras[0].limits, HasSubstr("is on USB 2 (480 Mbit/s)"));
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video0");
  EXPECT_THAT(cameras[1].problem, HasSubstr("no calibration is known for USB device 1234:5678"));
  EXPECT_THAT(cameras[2].problem, HasSubstr("no colour node on the same device"));
}

TEST_F(V4l2List, ACameraThatHasFewerFramesWhereItIsComesAfterOneThatHasAll) {
  machine_.add(1, 0, with_rates(depth_node(), {60, 15, 6}), with_rates(colour_node(), {15, 30, 6}));
  machine_.add(2, 2, with_rates(depth_node(), {90, 60, 30}), with_rates(colour_node(), {60, 30}));
  machine_.camera(1).unplug();
  machine_.camera(1).on_bus("5000", "3.20");
  machine_.camera(1).plug(4);
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].address, "v4l2:/dev/video4");
  EXPECT_EQ(cameras[0].limits, "");
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video0?fps=15") << "which opens";
  EXPECT_THAT(cameras[1].limits, testing::AllOf(HasSubstr("USB 2"), HasSubstr("gives 15 frames a second, not 30")));
  EXPECT_EQ(cameras[1].problem, "");
  const auto camera = open_text(open_v4l2, cameras[1].address);
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  EXPECT_THAT((*camera)->description(), HasSubstr("15 frames a second"));
  EXPECT_THAT((*camera)->limits(), HasSubstr("is on USB 2 (480 Mbit/s)"));
  const auto fast = open_text(open_v4l2, cameras[0].address);
  ASSERT_TRUE(fast.ok()) << fast.error().text();
  EXPECT_EQ((*fast)->limits(), "");
}

TEST_F(V4l2List, OfTwoOnSlowPortsTheOneWithMoreFramesIsFirst) {
  machine_.add(1, 0, with_rates(depth_node(), {6}), with_rates(colour_node(), {6}));
  machine_.add(2, 2, with_rates(depth_node(), {30}), with_rates(colour_node(), {30}));
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].address, "v4l2:/dev/video2");
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video0?fps=6");
}

TEST_F(V4l2List, WhatCannotBeOpenedThereIsAProblem) {
  MockNodeConfig small = depth_node();
  small.sizes = {{480, 270}};
  machine_.add(1, 0, small, colour_node());
  machine_.add(2, 2, with_rates(depth_node(), {25}), with_rates(colour_node(), {30}));
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_THAT(cameras[0].problem,
              HasSubstr("/dev/video0: has no Z16 640x480, which its calibration is for; it has 480x270"));
  EXPECT_THAT(cameras[1].problem, HasSubstr("no frame rate in common"));
}

TEST_F(V4l2List, ACameraThatWasMadeForUsb2IsNotLimitedByIt) {
  machine_.add(1, 0, depth_node(), colour_node());
  for (const auto& [version, limited] : {std::pair(" 2.00", false), {" 2.10", true}}) {
    machine_.camera(0).unplug();
    machine_.camera(0).on_bus("480", version);
    machine_.camera(0).plug(limited ? 4 : 2);
    EXPECT_EQ(!list_v4l2().at(0).limits.empty(), limited) << version;
  }
}

TEST_F(V4l2List, WhatLimitsACameraIsThePortThatItIsPluggedInNow) {
  test::MockUvc& mock = machine_.add(1, 0, depth_node(), colour_node());
  mock.unplug();
  mock.on_bus("5000", "3.20");
  mock.plug(2);
  const auto camera = open_text(open_v4l2, "v4l2:");
  ASSERT_TRUE(camera.ok()) << camera.error().text();
  EXPECT_EQ((*camera)->limits(), "");
  FramePool pool((*camera)->intrinsics(), 1);
  Frame frame = pool.acquire();
  mock.unplug();
  mock.on_bus("480", "2.10");
  mock.plug(4);
  Grab grab = Grab::gone;
  for (int i = 0; i < 100 && grab != Grab::frame; ++i) grab = (*camera)->grab(frame, 100ms);
  ASSERT_EQ(grab, Grab::frame) << (*camera)->last_error().text();
  EXPECT_THAT((*camera)->limits(), HasSubstr("is on USB 2 (480 Mbit/s)"));
  EXPECT_THAT((*camera)->description(), HasSubstr("depth /dev/video4"));
}

TEST_F(V4l2List, ANodeWithY16AloneIsToldWithWhatToDo) {
  MockNodeConfig depth = depth_node();
  depth.formats = {V4L2_PIX_FMT_Y16};
  machine_.add(1, 0, depth, colour_node());
  MockNodeConfig infrared = colour_node({V4L2_PIX_FMT_Y16});
  machine_.add(2, 2, depth_node(), infrared);  // the body has Z16: this is not its depth
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].address, "v4l2:/dev/video0");
  EXPECT_THAT(cameras[0].problem, HasSubstr("offers Y16, which is depth or infrared, and no Z16"));
  EXPECT_THAT(cameras[0].problem, HasSubstr("name it as camera, v4l2:/dev/video0"));
  EXPECT_THAT(cameras[0].abilities, HasSubstr("depth /dev/video0 Y16 640x480"));
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video2");
}

// What a driver refuses to be asked is no reason not to tell of it; metadata nodes, of which each camera has some, are
// not told of.
TEST_F(V4l2List, NodesThatFailAreToldWithTheReason) {
  machine_.add(1, 0, depth_node(), colour_node());
  MockNodeConfig metadata = colour_node();
  metadata.captures = false;
  machine_.add(2, 2, metadata, metadata);
  machine_.camera(0).refuse_always(VIDIOC_QUERYCAP, EIO);
  const std::vector<CameraInfo> cameras = list_v4l2();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_THAT(cameras[0].problem, HasSubstr("/dev/video0: no colour node on the same device"));
  EXPECT_EQ(cameras[1].address, "v4l2:/dev/video1");
  EXPECT_EQ(cameras[1].description, "Mock depth camera S1 (USB 8086:0b07)");
  EXPECT_THAT(cameras[1].problem, HasSubstr("/dev/video1: no V4L2 device: Input/output error"));
}

}  // namespace
}  // namespace onemap::hal
