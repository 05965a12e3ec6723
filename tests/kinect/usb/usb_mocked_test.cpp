// Kinects on a USB bus that umockdev plays: what is listed, what is refused, who comes and goes. Runs in
// umockdev-wrapper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <thread>

#include "hal/backends/libusb.hpp"
#include "hal/backends/libusb/usb_watch.hpp"
#include "plain_bus.hpp"
#include "usb.hpp"

namespace onemap::hal::libusb {
namespace {

using namespace std::chrono_literals;
using test::device_of;
using Bus = test::PlainBus;
using testing::HasSubstr;

void handle_events(Usb& usb, const std::function<bool()>& until) {
  for (int tries = 0; tries < 400 && !until(); ++tries) {
    timeval wait{0, 20'000};
    libusb_handle_events_timeout(usb.context(), &wait);
  }
}

std::string open_error(const std::string& text) {
  const auto camera = open_libusb(*parse_camera_address(text));
  EXPECT_FALSE(camera.ok());
  return camera.ok() ? "" : camera.error().text();
}

TEST(KinectBus, WithoutAKinectThereIsNone) {
  const Bus bus;
  EXPECT_TRUE(list_libusb().empty());
  EXPECT_THAT(open_error("libusb:"), HasSubstr("no Kinect is connected"));
  EXPECT_THAT(open_error("libusb:A001"), HasSubstr("no Kinect with this serial number"));
  EXPECT_THAT(open_error("libusb:?tilt=3"), HasSubstr("unknown option 'tilt'"));
  EXPECT_THAT(open_error("libusb:?registration=yes"), HasSubstr("expected device, ours or none"));
  EXPECT_THAT(open_error("libusb:?fx=500"), HasSubstr("lacks fy cx cy"));
}

TEST(KinectBus, KinectsAreListedTheUsableFirstAndASlowPortIsTold) {
  Bus bus;
  bus.plug(1, "480");
  bus.plug(2, "12");
  const auto cameras = list_libusb();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_THAT(cameras[0].description, HasSubstr("bus 1 device 2"));
  EXPECT_EQ(cameras[0].problem, "");
  EXPECT_THAT(cameras[1].problem, HasSubstr("12 Mbit/s"));
}

// 045e:02bf, and what of a Kinect is no camera: its audio, 045e:02bb and others.
TEST(KinectBus, TheKinectForWindowsIsOneToo) {
  Bus bus;
  bus.plug(1, "480", 0xbb);
  bus.plug(2, "480", 0xbf);
  const auto cameras = list_libusb();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].description, "Kinect for Windows v1, USB bus 1 device 3");
  auto usb = Usb::open();
  ASSERT_TRUE(usb.ok());
  const auto arrives = [&](int port, unsigned char product) {
    bus.plug(port, "480", product);
    bool arrived = false;
    handle_events(**usb, [&] { return (arrived = arrived || (*usb)->wait_for_arrival(1ms)) || product == 0xbb; });
    return arrived;
  };
  EXPECT_FALSE(arrives(4, 0xbb));
  EXPECT_TRUE(arrives(5, 0xbf));
}

TEST(KinectBus, ASlowPortIsRefused) {
  Bus bus;
  bus.plug(1, "12");
  EXPECT_THAT(open_error("libusb:"), testing::AllOf(HasSubstr("bus 1 device 2"), HasSubstr("480 Mbit/s")));
}

TEST(KinectBus, ArrivalsAndDeparturesAreHeard) {
  Bus bus;
  bus.plug(1, "480");
  auto usb = Usb::open();
  ASSERT_TRUE(usb.ok()) << usb.error().text();
  (*usb)->watch(1, 2);
  EXPECT_FALSE((*usb)->wait_for_arrival(1ms));
  bus.plug(3, "480");
  bool arrived = false;
  handle_events(**usb, [&] { return arrived = arrived || (*usb)->wait_for_arrival(1ms); });
  EXPECT_TRUE(arrived);
  EXPECT_EQ((*usb)->kinects().size(), 2u);
  bus.unplug(3);
  handle_events(**usb, [&] { return (*usb)->kinects().size() == 1; });
  EXPECT_EQ((*usb)->kinects().size(), 1u);
  EXPECT_FALSE((*usb)->left()) << "another one";
  bus.unplug(1);
  handle_events(**usb, [&] { return (*usb)->left(); });
  EXPECT_TRUE((*usb)->left());
}

// The next piece of news, for a while; none is one without a camera.
UsbNews next_news(UsbWatch& watch, int now_s) {
  for (int tries = 0; tries < 400; ++tries) {
    const auto news = watch.news(Instant(std::chrono::seconds(now_s)));
    EXPECT_LE(news.size(), 1u);
    if (!news.empty()) return news[0];
    std::this_thread::sleep_for(5ms);
  }
  return {};
}

TEST(UsbWatchMocked, EveryMakersCamerasComeGoAndAreReset) {
  Bus bus;
  auto watch = UsbWatch::start();
  ASSERT_TRUE(watch.ok()) << watch.error().text();
  bus.plug(1, "5000", device_of(0x8086, 0x0b07, 0x0320));
  UsbNews one = next_news(**watch, 10);
  EXPECT_EQ(one.what, UsbNews::What::came);
  EXPECT_THAT(one.camera, HasSubstr("Intel RealSense 8086:0b07, USB bus 1"));
  EXPECT_EQ(one.problem, "");
  bus.unplug(1);
  one = next_news(**watch, 20);
  EXPECT_EQ(one.what, UsbNews::What::left);
  EXPECT_THAT(one.text(), testing::EndsWith(" left"));
  bus.plug(1, "5000", device_of(0x8086, 0x0b07, 0x0320));
  one = next_news(**watch, 22);
  EXPECT_EQ(one.what, UsbNews::What::reset) << "two seconds later";
  EXPECT_THAT(one.text(), testing::EndsWith(" was reset"));
  bus.unplug(1);
  EXPECT_EQ(next_news(**watch, 30).what, UsbNews::What::left);
  bus.plug(1, "5000", device_of(0x8086, 0x0b07, 0x0320));
  EXPECT_EQ(next_news(**watch, 40).what, UsbNews::What::came) << "ten seconds later";
  bus.plug(2, "480", device_of(0x2bc5, 0x0669, 0x0200));
  EXPECT_THAT(next_news(**watch, 50).camera, HasSubstr("Orbbec 2bc5:0669"));
  bus.plug(3, "480", device_of(0x1d27, 0x0601, 0x0200));
  EXPECT_THAT(next_news(**watch, 50).camera, HasSubstr("PrimeSense or Xtion 1d27:0601"));
}

TEST(UsbWatchMocked, APortThatIsTooSlowIsToldAndWhatIsNoCameraIsNot) {
  Bus bus;
  auto watch = UsbWatch::start();
  ASSERT_TRUE(watch.ok()) << watch.error().text();
  bus.plug(1, "480", device_of(0x046d, 0x0825, 0x0200));  // somebody's webcam
  bus.plug(2, "480", device_of(0x8086, 0x0026, 0x0200));  // something else of Intel's
  bus.plug(3, "480", device_of(0x8086, 0x0b3a, 0x0210));
  UsbNews one = next_news(**watch, 1);
  EXPECT_THAT(one.camera, HasSubstr("8086:0b3a")) << "not the others";
  EXPECT_THAT(one.text(), HasSubstr(" came; it is on USB 2 (480 Mbit/s)"));
  bus.plug(4, "480");
  one = next_news(**watch, 2);
  EXPECT_THAT(one.camera, HasSubstr("Kinect v1 045e:02ae"));
  EXPECT_EQ(one.problem, "") << "it was made for USB 2";
  bus.plug(5, "12");
  EXPECT_THAT(next_news(**watch, 3).problem, HasSubstr("12 Mbit/s"));
}

}  // namespace
}  // namespace onemap::hal::libusb
