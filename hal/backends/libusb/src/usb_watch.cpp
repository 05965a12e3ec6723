#include "hal/backends/libusb/usb_watch.hpp"

#include <fmt/format.h>
#include <libusb.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "usb.hpp"

namespace onemap::hal {

namespace {

using What = UsbNews::What;

constexpr Duration kReset = std::chrono::seconds(5);  // who is back where it was within this time was reset
constexpr std::uint16_t kMadeForUsb3 = 0x0210;        // what a USB 3 device calls itself on a USB 2 port, or more

struct Maker {
  int vendor, first, last;  // products
  std::string_view name;
};
constexpr std::array kMakers{Maker{0x045e, 0x02ae, 0x02ae, "Kinect v1"},
                             Maker{0x045e, 0x02bf, 0x02bf, "Kinect for Windows v1"},
                             Maker{0x1d27, 0x0000, 0xffff, "PrimeSense or Xtion"},
                             Maker{0x2bc5, 0x0000, 0xffff, "Orbbec"}, Maker{0x8086, 0x0a66, 0x0b6f, "Intel RealSense"}};

const Maker* maker_of(const libusb_device_descriptor& of) {
  const auto made = [&](const Maker& m) {
    return m.vendor == of.idVendor && of.idProduct >= m.first && of.idProduct <= m.last;
  };
  const auto found = std::ranges::find_if(kMakers, made);
  return found == kMakers.end() ? nullptr : &*found;
}

std::string problem_of(libusb_device* device, const libusb_device_descriptor& of) {
  const int speed = libusb_get_device_speed(device);
  if (std::string problem = libusb::speed_problem(speed); !problem.empty()) return problem;
  if (speed != LIBUSB_SPEED_HIGH || of.bcdUSB < kMadeForUsb3) return {};
  return "is on USB 2 (480 Mbit/s), where it has fewer sizes and frame rates than on USB 3: another port or cable "
         "changes that";
}

}  // namespace

std::string UsbNews::text() const {
  constexpr std::array kWords{"came", "left", "was reset"};
  return fmt::format("{} {}{}{}", camera, kWords[static_cast<std::size_t>(what)], problem.empty() ? "" : "; it ",
                     problem);
}

struct UsbWatch::Parts {
  struct Gone {
    std::string camera;
    Instant at;
  };
  ~Parts() {
    if (context) libusb_exit(context);
  }
  static int on_hotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* self);
  void note(UsbNews one);

  libusb_context* context = nullptr;
  Instant now{};
  std::vector<UsbNews> unsaid;
  std::vector<Gone> gone;  // lately
};

void UsbWatch::Parts::note(UsbNews one) {
  std::erase_if(gone, [&](const Gone& other) { return now - other.at > kReset; });
  if (one.what == What::left) {
    gone.push_back({one.camera, now});
  } else if (std::erase_if(gone, [&](const Gone& other) { return other.camera == one.camera; }) > 0) {
    one.what = What::reset;
  }
  unsaid.push_back(std::move(one));
}

int UsbWatch::Parts::on_hotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* self) {
  libusb_device_descriptor of{};
  if (libusb_get_device_descriptor(device, &of) != 0) return 0;
  const Maker* maker = maker_of(of);
  if (!maker) return 0;
  const bool came = event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED;
  const std::string port = libusb::port_of(device);
  static_cast<Parts*>(self)->note(
      {came ? What::came : What::left,
       fmt::format("{} {:04x}:{:04x}, USB bus {}{}{}", maker->name, of.idVendor, of.idProduct,
                   libusb_get_bus_number(device), port.empty() ? "" : " port ", port),
       came ? problem_of(device, of) : ""});
  return 0;  // keep listening
}

UsbWatch::UsbWatch(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
UsbWatch::~UsbWatch() = default;

Result<std::unique_ptr<UsbWatch>> UsbWatch::start() {
  auto parts = std::make_unique<Parts>();
  const auto failed = [](int code) {
    return Error{"USB", std::string("nothing is heard of cameras that come and go: ") +
                            libusb_strerror(static_cast<libusb_error>(code))};
  };
  if (const int code = libusb_init(&parts->context); code != 0) return failed(code);
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) return failed(LIBUSB_ERROR_NOT_SUPPORTED);
  const int events = LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT;
  if (const int code = libusb_hotplug_register_callback(parts->context, events, 0, LIBUSB_HOTPLUG_MATCH_ANY,
                                                        LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
                                                        Parts::on_hotplug, parts.get(), nullptr);
      code != 0)
    return failed(code);
  return std::unique_ptr<UsbWatch>(new UsbWatch(std::move(parts)));
}

std::vector<UsbNews> UsbWatch::news(Instant now) {
  parts_->now = now;
  timeval none{0, 0};
  libusb_handle_events_timeout(parts_->context, &none);
  return std::exchange(parts_->unsaid, {});
}

}  // namespace onemap::hal
