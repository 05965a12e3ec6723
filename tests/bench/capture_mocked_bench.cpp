// What capture takes of a core where umockdev plays the device and the libraries are the real ones: the V4L2 backend,
// and the Kinect's with libfreenect, whose threads are counted in. What umockdev takes on them to bring a call to the
// device is in the figure, too: a system call is cheaper, so the share is said. Run it under umockdev-wrapper.
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <semaphore>
#include <thread>

#include "hal/backends/simulated.hpp"
#include "hal/backends/v4l2.hpp"
#include "hal/camera_contract.hpp"
#include "hal/frame_pool.hpp"
#include "hal/v4l2/mock_machine.hpp"
#include "virtual_kinect.hpp"

namespace {

using namespace onemap;
using namespace std::chrono_literals;

constexpr int kWarm = 10, kFrames = 80;
constexpr std::int64_t kInterval_us = 33'333;

// Processor time of each of this process's threads.
std::map<std::string, double> threads_s() {
  std::map<std::string, double> all;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    double ns = 0;
    std::ifstream(task.path() / "schedstat") >> ns;
    all[task.path().filename()] = 1e-9 * ns;
  }
  return all;
}

// A camera's cost is that of this thread and of those that are new since it was opened.
class Cost {
 public:
  Cost() : before_(threads_s()), self_(std::to_string(gettid())) {}
  double spent_s() const {
    double sum = 0;
    for (const auto& [thread, spent] : threads_s())
      if (thread == self_ || !before_.contains(thread)) sum += spent;
    return sum;
  }

 private:
  const std::map<std::string, double> before_;
  const std::string self_;
};

struct Calls {
  double cost_s = 0;                         // of one, to this process's thread that makes it
  std::function<std::uint64_t()> made = {};  // so far
};

void measure(const std::string& name, hal::DepthCamera& camera, const Cost& cost, const std::function<void()>& before,
             const Calls& calls) {
  hal::FramePool pool(camera.intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  const auto fetch = [&](int frames) {
    int got = 0;
    for (int tries = 0; got < frames && tries < 40 * frames; ++tries) {
      before();
      got += camera.grab(frame, 50ms) == hal::Grab::frame;
    }
    return got;
  };
  fetch(kWarm);
  const double spent_before = cost.spent_s();
  const std::uint64_t made_before = calls.made();
  const int frames = fetch(kFrames);
  const double ms = 1000 * (cost.spent_s() - spent_before) / frames;
  const double made = static_cast<double>(calls.made() - made_before) / frames;
  const double mock_ms = 1000 * made * calls.cost_s;
  fmt::print(
      "{:44} {:5.2f} ms a frame, {:4.1f} % of a core at 30 Hz; without umockdev's part of {:.1f} calls {:4.1f} %"
      " ({} frames, {} missed)\n",
      name, ms, 3 * ms, made, 3 * (ms - mock_ms), frames, camera.counters().missed);
}

double cost_of(const std::function<void()>& call) {
  constexpr int kCalls = 2000;
  const std::string self = std::to_string(gettid());
  const double before = threads_s()[self];
  for (int i = 0; i < kCalls; ++i) call();
  return (threads_s()[self] - before) / kCalls;
}

// A room's picture as the nodes of a camera send it.
struct RoomPicture {
  RoomPicture() {
    const auto camera =
        std::move(hal::open_simulated(*hal::parse_camera_address("simulated:living-room?seed=3"))).value();
    hal::FramePool pool(camera->intrinsics(), 1);
    hal::Frame frame = pool.acquire();
    if (camera->grab(frame, {}) != hal::Grab::frame) return;
    for (const std::uint16_t value : frame.depth()) depth.push_back(static_cast<std::uint16_t>(value / 5));
    for (std::size_t i = 0; i < frame.rgb().size(); i += 3) {  // luma and chroma, roughly
      const std::uint8_t* p = &frame.rgb()[i];
      const int y = (p[0] + 2 * p[1] + p[2]) / 4;
      yuyv.push_back(static_cast<std::uint8_t>(16 + y * 219 / 255));
      yuyv.push_back(static_cast<std::uint8_t>(128 + (i / 3 % 2 == 0 ? p[2] - y : p[0] - y) / 2));
    }
    if (!hal::imaging::encode_jpeg({640, 480}, frame.rgb(), 85, jpeg)) jpeg.clear();
  }
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> yuyv, jpeg;
};

void v4l2() {
  const RoomPicture room;
  for (const bool jpeg : {false, true}) {
    test::Machine machine;
    test::MockNodeConfig depth = test::depth_node();
    test::MockNodeConfig colour = test::colour_node({jpeg ? V4L2_PIX_FMT_MJPEG : test::kYuyv});
    depth.content = [&](const test::MockMode&, std::uint32_t, std::uint8_t* out, std::uint32_t) {
      std::memcpy(out, room.depth.data(), 2 * room.depth.size());
    };
    colour.content = [&](const test::MockMode&, std::uint32_t, std::uint8_t* out, std::uint32_t) {
      std::ranges::copy(jpeg ? room.jpeg : room.yuyv, out);
    };
    test::MockUvc& mock = machine.add(1, 0, depth, colour);
    const int node = ::open("/dev/video0", O_RDWR);
    v4l2_capability can{};
    const Calls calls{cost_of([&] { ioctl(node, VIDIOC_QUERYCAP, &can); }), [&] { return mock.calls(); }};
    close(node);
    for (const auto& [how, options] : {std::pair{"depth not copied", "?calibration=" + machine.file("registered.txt")},
                                       {"depth registered by us (D435)", std::string()}}) {
      const Cost cost;
      const auto camera = hal::open_text(hal::open_v4l2, "v4l2:" + options);
      if (!camera.ok()) {
        fmt::print("v4l2: {}\n", camera.error().text());
        continue;
      }
      measure(
          fmt::format("v4l2, {}, {}", jpeg ? "MJPEG" : "YUYV", how), **camera, cost, [&] { mock.pass(kInterval_us); },
          calls);
    }
  }
}

// Takes a picture when it is asked, on a thread of the device's own, so that none is late.
class Photographer {
 public:
  explicit Photographer(test::VirtualKinect& kinect)
      : thread_([this, &kinect] {
          for (asked_.acquire(); !over_; asked_.acquire()) kinect.release();
        }) {}
  ~Photographer() {
    over_ = true;
    asked_.release();
    thread_.join();
  }
  void ask() { asked_.release(); }

 private:
  std::atomic<bool> over_ = false;
  std::counting_semaphore<> asked_{0};
  std::thread thread_;
};

void kinect() {
  const test::Film film = test::Film::shoot("simulated:living-room?seed=3&frames=30", test::KinectDevice::develop);
  for (const char* who : {"device", "ours"}) {
    test::MockBus bus;
    test::VirtualKinect kinect(bus, 1, film, "KINECT01");
    kinect.plug();
    const int node = ::open("/dev/bus/usb/001/002", O_RDWR);
    unsigned capabilities = 0;
    const Calls calls{cost_of([&] { ioctl(node, USBDEVFS_GET_CAPABILITIES, &capabilities); }),
                      [&] { return bus.calls(); }};
    close(node);
    Photographer photographer(kinect);
    const Cost cost;
    const auto camera = hal::open_text(hal::open_libusb, fmt::format("libusb:?registration={}", who));
    if (!camera.ok()) {
      fmt::print("libusb: {}\n", camera.error().text());
      continue;
    }
    std::uint64_t asked = 0;
    const auto ask = [&] {
      if (asked > (*camera)->counters().frames) return;
      ++asked;
      photographer.ask();
    };
    measure(fmt::format("libusb (Kinect v1), registration={}", who), **camera, cost, ask, calls);
  }
}

}  // namespace

int main() {
  if (!test::MockTestbed::wrapped()) {
    fmt::print("umockdev-wrapper is not around this program (Debian: umockdev)\n");
    return 77;
  }
  v4l2();
  kinect();
}
