// What capture takes of a core, camera by camera: the processor time of the thread that fetches frames, at the camera's
// own pace of 30 Hz, through the real libraries on devices of our own. The peer is the V4L2 path without a driver:
// bench_imaging's v4l2_frame. What a library does in threads of its own (libfreenect decodes there) is not in it: that
// is bench_capture_mocked's.
#include <fmt/format.h>
#include <time.h>

#include "hal/backends/libusb.hpp"
#include "hal/backends/openni2.hpp"
#include "hal/backends/simulated.hpp"
#ifdef ONEMAP_OPENNI2_DIR
#include "support/openni2_devices.hpp"
#endif
#ifdef ONEMAP_FAKENECT_DIR
#include "support/kinect_session.hpp"
#endif
#include "support/temp_folder.hpp"

namespace {

using namespace onemap;
using namespace std::chrono_literals;

constexpr int kWarm = 10, kFrames = 80;

double thread_cpu_s() {
  timespec at{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

void measure(const std::string& name, Result<std::unique_ptr<hal::DepthCamera>> opened) {
  if (!opened.ok()) {
    fmt::print("{}: {}\n", name, opened.error().text());
    return;
  }
  hal::DepthCamera& camera = **opened;
  hal::FramePool pool(camera.intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  const auto fetch = [&](int frames) {
    int got = 0;
    for (int tries = 0; got < frames && tries < 40 * frames; ++tries)
      got += camera.grab(frame, 50ms) == hal::Grab::frame;
    return got;
  };
  fetch(kWarm);
  const double before = thread_cpu_s();
  const int frames = fetch(kFrames);
  const double spent_s = thread_cpu_s() - before;
  fmt::print("{:38} {:5.2f} ms a frame, {:4.1f} % of a core at 30 Hz ({} frames)\n", name, 1000 * spent_s / frames,
             3000 * spent_s / frames, frames);
}

#ifdef ONEMAP_OPENNI2_DIR
void openni2() {
  test::OpenNi2Devices devices;
  devices.plug("a", "room simulated:living-room?seed=3\nhz 30\n");
  for (const char* who : {"device", "ours"})
    measure(fmt::format("openni2, registration={}", who),
            hal::open_openni2(*hal::parse_camera_address(fmt::format("openni2:?registration={}", who))));
}
#endif

#ifdef ONEMAP_FAKENECT_DIR
// It plays its session once, and offers disparities only: they become millimetres, and are registered by us.
void kinect() {
  const test::TempFolder session;
  test::write_kinect_session(session.path(), "simulated:living-room?seed=3", kWarm + kFrames + 5, 30);
  setenv("FAKENECT_PATH", session.path().c_str(), 1);
  measure("libusb (Kinect v1), registration=ours",
          hal::open_libusb(*hal::parse_camera_address("libusb:?registration=ours")));
}
#endif

}  // namespace

int main() {
#ifdef ONEMAP_OPENNI2_DIR
  openni2();
#else
  fmt::print("openni2: libopenni2-dev is missing\n");
#endif
#ifdef ONEMAP_FAKENECT_DIR
  kinect();
#else
  fmt::print("libusb: libfreenect-dev with its fakenect is missing\n");
#endif
}
