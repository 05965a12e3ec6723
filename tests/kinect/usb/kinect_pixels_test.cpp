// What we make of a Kinect's own bytes beside what libfreenect makes of them: its registered depth and its RGB, of the
// same picture of the same virtual Kinect.
#include <gtest/gtest.h>
#include <libfreenect.h>
#include <libusb.h>

#include <algorithm>
#include <cstdlib>

#include "hal/frame_pool.hpp"
#include "virtual_kinect.hpp"

namespace onemap::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kKinectPixels = 640 * 480;

struct LibraryImages {
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kKinectPixels);
  std::vector<std::uint8_t> rgb = std::vector<std::uint8_t>(3 * kKinectPixels);
  bool has_depth = false, has_rgb = false;
};

LibraryImages images_by_libfreenect(test::VirtualKinect& kinect) {
  LibraryImages out;
  libusb_context* usb = nullptr;
  freenect_context* context = nullptr;
  freenect_device* device = nullptr;
  EXPECT_EQ(libusb_init(&usb), 0);
  EXPECT_EQ(freenect_init(&context, usb), 0);
  freenect_select_subdevices(context, FREENECT_DEVICE_CAMERA);
  EXPECT_EQ(freenect_open_device(context, &device, 0), 0);
  freenect_set_user(device, &out);
  freenect_set_depth_callback(device, [](freenect_device* from, void*, std::uint32_t) {
    static_cast<LibraryImages*>(freenect_get_user(from))->has_depth = true;
  });
  freenect_set_video_callback(device, [](freenect_device* from, void*, std::uint32_t) {
    static_cast<LibraryImages*>(freenect_get_user(from))->has_rgb = true;
  });
  freenect_set_depth_mode(device, freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_REGISTERED));
  freenect_set_video_mode(device, freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB));
  freenect_set_depth_buffer(device, out.depth.data());
  freenect_set_video_buffer(device, out.rgb.data());
  EXPECT_EQ(freenect_start_depth(device), 0);
  EXPECT_EQ(freenect_start_video(device), 0);
  kinect.release();
  for (int tries = 0; tries < 1000 && !(out.has_depth && out.has_rgb); ++tries) {
    timeval wait{0, 20'000};
    freenect_process_events_timeout(context, &wait);
  }
  freenect_stop_depth(device);
  freenect_stop_video(device);
  freenect_close_device(device);
  freenect_shutdown(context);
  libusb_exit(usb);
  return out;
}

TEST(KinectPixels, RegisteredDepthIsLibfreenectsToTheMillimetreAndColourToItsRounding) {
  const test::Film film =
      test::Film::shoot("simulated:living-room?seed=3&frames=1", test::KinectDevice::develop);  // every picture is this
  test::MockBus bus;
  test::VirtualKinect kinect(bus, 1, film, "KINECT01");
  kinect.plug();
  const LibraryImages theirs = images_by_libfreenect(kinect);
  ASSERT_TRUE(theirs.has_depth && theirs.has_rgb);
  auto opened = open_libusb(*parse_camera_address("libusb:?registration=device"));
  ASSERT_TRUE(opened.ok()) << opened.error().text();
  test::OnDemand camera(std::move(*opened), kinect);
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  Grab grab = Grab::timeout;
  for (int tries = 0; tries < 400 && grab != Grab::frame; ++tries) grab = camera.grab(frame, 50ms);
  ASSERT_EQ(grab, Grab::frame) << camera.last_error().text();
  EXPECT_TRUE(std::ranges::equal(frame.depth(), theirs.depth));
  EXPECT_GT(std::ranges::count_if(theirs.depth, [](std::uint16_t mm) { return mm > 0; }), 100'000);
  int most = 0;  // theirs rounds down, and each mean of means, too; its image's sides are made otherwise
  for (std::size_t y = 1; y + 1 < 480; ++y)
    for (std::size_t i = 3 * (640 * y + 1); i < 3 * (640 * y + 639); ++i)
      most = std::max(most, std::abs(frame.rgb()[i] - theirs.rgb[i]));
  EXPECT_LE(most, 1);
}

}  // namespace
}  // namespace onemap::hal
