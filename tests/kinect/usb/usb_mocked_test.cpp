// Kinects on a USB bus that umockdev plays: what is listed, what is refused, who comes and goes. Runs in
// umockdev-wrapper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <umockdev.h>

#include <array>
#include <functional>
#include <string>

#include "hal/backends/libusb.hpp"
#include "usb.hpp"

namespace onemap::hal::libusb {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// A Kinect's camera as its descriptors say it: device, configuration, interface, two isochronous endpoints. It has no
// serial number, as some have none.
constexpr std::array<unsigned char, 50> kDescriptors{
    18, 1, 0x00, 0x02, 0,    0,    0,    64,   0x5e, 0x04, 0xae, 0x02, 0x0b, 0x01, 1, 2, 0, 1,  //
    9,  2, 32,   0,    1,    1,    0,    0xc0, 250,                                             //
    9,  4, 0,    0,    2,    0xff, 0xff, 0xff, 0,                                               //
    7,  5, 0x81, 1,    0x80, 0x0b, 1,    7,    5,    0x82, 1,    0x80, 0x0b, 1};

class Bus {
 public:
  Bus() : testbed_(umockdev_testbed_new()) {}
  ~Bus() { g_object_unref(testbed_); }
  void plug(int port, const std::string& speed, unsigned char product = 0xae) {
    auto descriptors = kDescriptors;
    descriptors[10] = product;
    std::string hex;
    for (const unsigned char byte : descriptors) {
      constexpr const char* kDigits = "0123456789ABCDEF";
      hex += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
    const std::string number = "00" + std::to_string(port + 1);
    const std::string device = "P: " + path(port).substr(4) + "\nN: bus/usb/001/" + number +
                               "\nE: DEVNAME=/dev/bus/usb/001/" + number +
                               "\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nE: BUSNUM=001\nE: DEVNUM=" + number +
                               "\nA: busnum=1\\n\nA: devnum=" + std::to_string(port + 1) + "\\n\nA: speed=" + speed +
                               "\\n\nA: bConfigurationValue=1\\n\nH: descriptors=" + hex + "\n";
    GError* error = nullptr;
    EXPECT_TRUE(umockdev_testbed_add_from_string(testbed_, device.c_str(), &error)) << (error ? error->message : "");
    umockdev_testbed_uevent(testbed_, path(port).c_str(), "add");
  }
  void unplug(int port) {
    umockdev_testbed_uevent(testbed_, path(port).c_str(), "remove");
    umockdev_testbed_remove_device(testbed_, path(port).c_str());
  }

 private:
  static std::string path(int port) { return "/sys/devices/usb1/1-" + std::to_string(port); }
  UMockdevTestbed* testbed_;
};

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

}  // namespace
}  // namespace onemap::hal::libusb
