#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/backends/openni2/usb_place.hpp"
#include "support/temp_folder.hpp"

// What the kernel tells of the USB devices that OpenNI2's drivers name.
namespace onemap::hal::openni2 {
namespace {

void plug_usb(const test::TempFolder& root, const std::string& port, const std::string& device,
              const std::string& speed) {
  const std::string folder = "sys/bus/usb/devices/" + port + "/";
  root.write(folder + "busnum", "3\n");
  root.write(folder + "devnum", device + "\n");
  root.write(folder + "speed", speed + "\n");
  root.write("dev/bus/usb/003/0" + (device.size() < 2 ? "0" + device : device), "");
}

TEST(OpenNi2Usb, ADeviceAtASlowPortCannotBeUsed) {
  const test::TempFolder root;
  plug_usb(root, "3-1", "7", "480");
  plug_usb(root, "3-2", "12", "12");
  const std::string at = root.path().string();
  EXPECT_EQ(usb_problem("1d27/0601@3/7", at), "");
  EXPECT_EQ(usb_problem("1d27/0601@3/12", at), "runs at 12 Mbit/s; it needs a USB 2 port with 480 Mbit/s");
}

TEST(OpenNi2Usb, ADeviceThatWeMayNotOpenCannotBeUsed) {
  const test::TempFolder root;
  plug_usb(root, "3-1", "7", "480");
  EXPECT_EQ(usb_problem("1d27/0601@3/8", root.path().string()), "/dev/bus/usb/003/008: No such file or directory");
}

TEST(OpenNi2Usb, WhatIsNoUsbDeviceHasNoProblemOfOne) {
  const test::TempFolder root;
  for (const char* uri : {"room://a", "/home/robot@3/walk.oni", "1d27/0601@3", "1d27/0601@/7", ""})
    EXPECT_EQ(usb_problem(uri, root.path().string()), "") << uri;
}

}  // namespace
}  // namespace onemap::hal::openni2
