// What capture takes of a core where umockdev plays the device and the libraries are the real ones: the V4L2 backend,
// and the Kinect's with libfreenect, whose threads are counted in. umockdev brings a call to the device through a
// socket; what these threads spend in that is measured call by call, and said with and without it. What the kernel
// would take for such a call is in neither. Each figure is the median of some rounds. Run it under umockdev-wrapper.
#include <dlfcn.h>
#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdarg>
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

std::atomic<std::int64_t> mock_ns = 0;  // of processor time
std::atomic<std::uint64_t> mock_calls = 0;

std::int64_t thread_ns() {
  timespec at{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
  return at.tv_sec * 1'000'000'000 + at.tv_nsec;
}

}  // namespace

// In place of umockdev's, which it calls: every ioctl of this process goes to a device.
extern "C" int ioctl(int file, unsigned long request, ...) noexcept {
  using Ioctl = int (*)(int, unsigned long, void*);
  static const auto next = reinterpret_cast<Ioctl>(dlsym(RTLD_NEXT, "ioctl"));
  va_list rest;
  va_start(rest, request);
  void* argument = va_arg(rest, void*);
  va_end(rest);
  const std::int64_t before = thread_ns();
  const int result = next(file, request, argument);
  const std::int64_t after = thread_ns();
  mock_ns += after - before + (thread_ns() - after);  // this asking takes a while itself
  ++mock_calls;
  return result;
}

namespace {

using namespace onemap;
using namespace std::chrono_literals;

constexpr int kWarm = 10, kFrames = 60, kRounds = 5;
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

double median(std::array<double, kRounds> of) {
  std::ranges::nth_element(of, of.begin() + kRounds / 2);
  return of[kRounds / 2];
}

void measure(const std::string& name, hal::DepthCamera& camera, const Cost& cost, const std::function<void()>& before) {
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
  std::array<double, kRounds> all{}, ours{}, calls{};
  for (std::size_t round = 0; round < kRounds; ++round) {
    const double spent_before = cost.spent_s(), mock_before = 1e-9 * static_cast<double>(mock_ns);
    const std::uint64_t calls_before = mock_calls;
    const double frames = fetch(kFrames);
    all[round] = 1000 * (cost.spent_s() - spent_before) / frames;
    ours[round] = all[round] - 1000 * (1e-9 * static_cast<double>(mock_ns) - mock_before) / frames;
    calls[round] = static_cast<double>(mock_calls - calls_before) / frames;
  }
  fmt::print(
      "{:44} {:4.2f} ms a frame, {:4.1f} % of a core at 30 Hz; of it umockdev's {:.0f} calls {:4.1f} %, the rest"
      " {:4.1f} % ({} missed)\n",
      name, median(all), 3 * median(all), median(calls), 3 * (median(all) - median(ours)), 3 * median(ours),
      camera.counters().missed);
  std::fflush(stdout);
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
    for (const auto& [how, options] : {std::pair{"depth not copied", "?calibration=" + machine.file("registered.txt")},
                                       {"depth registered by us (D435)", std::string()}}) {
      const Cost cost;
      const auto camera = hal::open_text(hal::open_v4l2, "v4l2:" + options);
      if (!camera.ok()) {
        fmt::print("v4l2: {}\n", camera.error().text());
        continue;
      }
      measure(fmt::format("v4l2, {}, {}", jpeg ? "MJPEG" : "YUYV", how), **camera, cost,
              [&] { mock.pass(kInterval_us); });
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
    measure(fmt::format("libusb (Kinect v1), registration={}", who), **camera, cost, ask);
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
