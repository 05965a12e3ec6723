// A Kinect that is pulled out at the wrong moment, or has a twin: the real libfreenect and libusb on a virtual one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/frame_pool.hpp"
#include "virtual_kinect.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const test::Film& film() {
  static const auto film = test::Film::shoot("simulated:office?seed=4&frames=3", test::KinectDevice::develop);
  return film;
}

Result<std::unique_ptr<DepthCamera>> open(const std::string& address) {
  return open_libusb(*parse_camera_address(address));
}

Grab grab_past(DepthCamera& camera, Frame& frame, Grab pass) {
  Grab grab = pass;
  for (int i = 0; i < 400 && grab == pass; ++i) grab = camera.grab(frame, 50ms);
  return grab;
}

// From the first question for its number to the last transfer of its streams. libfreenect goes on when these fail: then
// it is open, and gone.
TEST(KinectFaults, PulledOutWhileItIsOpenedItIsAnErrorOrGone) {
  test::MockBus bus;
  test::VirtualKinect kinect(bus, 1, film(), "KINECT01");
  int errors = 0, gone = 0;
  for (int step = 0; step < 60; ++step) {
    kinect.plug();
    kinect.pull_out_at(step);
    const auto camera = open("libusb:");
    if (!camera.ok()) {
      EXPECT_NE(camera.error().reason, "") << step;
      ++errors;
    }
    kinect.unplug();
    if (!camera.ok()) continue;
    FramePool pool((*camera)->intrinsics(), 1);
    Frame frame = pool.acquire();
    EXPECT_EQ(grab_past(**camera, frame, Grab::timeout), Grab::gone) << step;
    ++gone;
  }
  EXPECT_GT(errors, 5);
  EXPECT_GT(gone, 5);
}

TEST(KinectFaults, PulledOutWhileItIsOpenedAgainItComesBackAllTheSame) {
  test::MockBus bus;
  test::VirtualKinect kinect(bus, 1, film(), "KINECT01");
  kinect.plug();
  auto opened = open("libusb:");
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  test::OnDemand camera(std::move(*opened), kinect);
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(grab_past(camera, frame, Grab::timeout), Grab::frame);
  for (const int step : {3, 8, 16, 24, 40}) {
    kinect.unplug();
    ASSERT_EQ(grab_past(camera, frame, Grab::timeout), Grab::gone) << step;
    kinect.plug();
    kinect.pull_out_at(step);
    // Gone, or opened to the end before the pull was noticed.
    for (int i = 0; i < 5; ++i) ASSERT_NE(camera.grab(frame, 20ms), Grab::frame) << step;
  }
  kinect.unplug();
  kinect.plug();
  const Grab grab = grab_past(camera, frame, Grab::gone);
  EXPECT_EQ(grab == Grab::timeout ? grab_past(camera, frame, Grab::timeout) : grab, Grab::frame)
      << camera.last_error().text();
}

// Some have no serial number, and some that of all of their model.
TEST(KinectFaults, OneThatHasTheSameSerialNumberIsNotTakenForTheOneThatLeft) {
  test::MockBus bus;
  test::VirtualKinect a(bus, 1, film(), "0000000000000000"), b(bus, 2, film(), "0000000000000000");
  a.plug();
  b.plug();
  const bool first_is_a = list_libusb().front().description.ends_with("device 2");
  test::VirtualKinect &one = first_is_a ? a : b, &twin = first_is_a ? b : a;
  auto opened = open("libusb:0000000000000000");
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  test::OnDemand camera(std::move(*opened), one);
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  ASSERT_EQ(grab_past(camera, frame, Grab::timeout), Grab::frame);
  one.unplug();
  ASSERT_EQ(grab_past(camera, frame, Grab::timeout), Grab::gone);
  for (int i = 0; i < 30; ++i) ASSERT_EQ(camera.grab(frame, 50ms), Grab::gone) << "the twin is there";
  // A hub that was reset: both come anew, and the twin is what a look finds first.
  twin.unplug();
  (first_is_a ? twin : one).plug();
  (first_is_a ? one : twin).plug();
  const Grab grab = grab_past(camera, frame, Grab::gone);
  EXPECT_EQ(grab == Grab::timeout ? grab_past(camera, frame, Grab::timeout) : grab, Grab::frame)
      << camera.last_error().text();
}

TEST(KinectFaults, SerialNumbersAreWhateverADeviceSays) {
  test::MockBus bus;
  test::VirtualKinect slash(bus, 1, film(), "../A/B"), question(bus, 2, film(), "A?fx=3");
  slash.plug();
  question.plug();
  const auto cameras = list_libusb();
  ASSERT_EQ(cameras.size(), 2u);
  std::vector<std::string> addresses;
  for (const CameraInfo& camera : cameras) addresses.push_back(camera.address);
  EXPECT_THAT(addresses, testing::UnorderedElementsAre("libusb:../A/B", "libusb:"))
      << "what follows a question mark would be options";
  for (const std::string& address : addresses) EXPECT_TRUE(open(address).ok()) << address;
  const auto none = open("libusb:C");
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().text(),
              testing::AllOf(HasSubstr("no Kinect with this serial number is connected; there is "),
                             HasSubstr("../A/B"), HasSubstr("A?fx=3")));
}

}  // namespace
}  // namespace onemap::hal
