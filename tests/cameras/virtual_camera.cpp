// virtual-camera shoot uvc|kinect ROOM FILE: draws a simulated room as such a camera sees it.
// virtual-camera uvc|kinect|uvc-slow|kinect-slow FILE [UNPLUG_AT SECONDS]: a USB camera that shows it, plugged into
// this machine's virtual host controller (modprobe vhci-hcd; root). It is pulled out once, at picture UNPLUG_AT, and
// plugged in again after so many seconds. Says on stdout what it does, and is silent after the last picture until it is
// killed. uvc-slow and kinect-slow: on a port of USB 2 and of USB 1.
// virtual-camera uvc|kinect FILE again PORT: the same at this port, over and over, until it is killed.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "film.hpp"
#include "kinect_device.hpp"
#include "usb_port.hpp"
#include "uvc_device.hpp"

namespace onemap::test {
namespace {

struct Wish {
  std::string kind, film;
  std::size_t unplug_at = 0;
  double away_s = 0;
  bool again = false;
  int port = 0;
};

void say(const std::string& what) {
  fmt::print("{}\n", what);
  std::fflush(stdout);
}

void shoot(const std::string& kind, const std::string& room, const std::string& file) {
  Film::shoot(room, kind == "kinect" ? KinectDevice::develop : UvcDevice::develop).store(file);
}

void run(const Wish& wish) {
  const bool kinect = wish.kind.starts_with("kinect"), slow = wish.kind.ends_with("-slow");
  const Film film = Film::load(wish.film);
  FilmProjector projector(film.pictures().size(), wish.again);
  std::unique_ptr<UsbDevice> device;
  if (kinect)
    device = std::make_unique<KinectDevice>(film, projector, fmt::format("KINECT{:02}", wish.port));
  else
    device = std::make_unique<UvcDevice>(film, projector);
  VhciPort port(kinect ? (slow ? UsbPort::Speed::full : UsbPort::Speed::high)
                       : (slow ? UsbPort::Speed::high : UsbPort::Speed::super),
                wish.port);
  setpriority(PRIO_PROCESS, 0, -10);  // a camera does not wait for the robot's processor
  device->plug(port);
  say("plugged in");
  for (bool pulled = wish.unplug_at == 0;;) {
    const auto now = std::chrono::steady_clock::now();
    const auto left = std::clamp<Moment::duration>(device->next_step() - now, Moment::duration::zero(),
                                                   std::chrono::milliseconds(100));
    const auto request = port.wait(static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count()));
    if (!port.plugged()) return say("the kernel let go of it");
    if (request) device->handle(*request, port);
    device->step(std::chrono::steady_clock::now(), port);
    if (pulled || projector.shown() < wish.unplug_at) continue;
    pulled = true;
    port.unplug();
    say("pulled out");
    std::this_thread::sleep_for(std::chrono::duration<double>(wish.away_s));
    device->plug(port);
    say("plugged in");
  }
}

}  // namespace
}  // namespace onemap::test

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  if (words.size() != 2 && words.size() != 4) {
    fmt::print(stderr, "virtual-camera shoot KIND ROOM FILE | KIND FILE [UNPLUG_AT SECONDS | again PORT]\n");
    return 2;
  }
  try {
    if (words[0] == "shoot" && words.size() == 4) {
      onemap::test::shoot(words[1], words[2], words[3]);
      return 0;
    }
    onemap::test::Wish wish{words[0], words[1]};
    if (words.size() == 4 && words[2] == "again") {
      wish.again = true;
      wish.port = std::stoi(words[3]);
    } else if (words.size() == 4) {
      wish.unplug_at = std::stoul(words[2]);
      wish.away_s = std::stod(words[3]);
    }
    onemap::test::run(wish);
  } catch (const std::exception& error) {
    fmt::print(stderr, "virtual-camera: {}\n", error.what());
  }
  return 1;
}
