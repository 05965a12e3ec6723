#include "usb.hpp"

#include <fmt/format.h>

#include <array>

namespace onemap::hal::libusb {

namespace {

constexpr int kMicrosoft = 0x045e, kKinectCamera = 0x02ae, kKinectForWindowsCamera = 0x02bf;

// Those that libfreenect opens, for its numbers are those of the devices that we list.
bool is_kinect(const libusb_device_descriptor& descriptor) {
  return descriptor.idVendor == kMicrosoft &&
         (descriptor.idProduct == kKinectCamera || descriptor.idProduct == kKinectForWindowsCamera);
}

int key_of(int bus, int address) { return bus * 256 + address; }

Plugged describe(libusb_device* device, const libusb_device_descriptor& descriptor) {
  Plugged out{libusb_get_bus_number(device),
              libusb_get_device_address(device),
              descriptor.idProduct == kKinectForWindowsCamera,
              port_of(device),
              "",
              speed_problem(libusb_get_device_speed(device))};
  libusb_device_handle* handle = nullptr;
  if (const int code = libusb_open(device, &handle); code != 0) {
    out.problem = std::string("cannot be opened: ") + libusb_strerror(static_cast<libusb_error>(code));
    return out;
  }
  std::array<unsigned char, 256> text{};
  const int size = descriptor.iSerialNumber == 0
                       ? 0
                       : libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, text.data(), text.size());
  if (size > 0) out.serial.assign(text.begin(), text.begin() + size);
  libusb_close(handle);
  return out;
}

}  // namespace

std::string port_of(libusb_device* device) {
  std::array<std::uint8_t, 7> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string text;
  for (int i = 0; i < depth; ++i) text += fmt::format("{}{}", i == 0 ? "" : ".", ports[static_cast<std::size_t>(i)]);
  return text;
}

std::string speed_problem(int libusb_speed) {
  switch (libusb_speed) {
    case LIBUSB_SPEED_LOW:
      return "runs at 1.5 Mbit/s; it needs a USB 2 port with 480 Mbit/s";
    case LIBUSB_SPEED_FULL:
      return "runs at 12 Mbit/s; it needs a USB 2 port with 480 Mbit/s";
    default:
      return {};
  }
}

Result<std::unique_ptr<Usb>> Usb::open() {
  std::unique_ptr<Usb> self(new Usb);
  if (const int code = libusb_init(&self->context_); code != 0)
    return Error{"libusb", std::string("cannot start: ") + libusb_strerror(static_cast<libusb_error>(code))};
  const int events = LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT;
  // Without it (a kernel without udev) departures still end the transfers, and arrivals are looked for.
  self->listens_ =
      libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) != 0 &&
      libusb_hotplug_register_callback(self->context_, events, 0, kMicrosoft, LIBUSB_HOTPLUG_MATCH_ANY,
                                       LIBUSB_HOTPLUG_MATCH_ANY, on_hotplug, self.get(), &self->callback_) == 0;
  return self;
}

Usb::~Usb() {
  if (listens_) libusb_hotplug_deregister_callback(context_, callback_);
  if (context_) libusb_exit(context_);
}

std::vector<Plugged> Usb::kinects() {
  std::vector<Plugged> out;
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context_, &devices);
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(devices[i], &descriptor) != 0) continue;
    if (is_kinect(descriptor)) out.push_back(describe(devices[i], descriptor));
  }
  if (count >= 0) libusb_free_device_list(devices, 1);
  return out;
}

void Usb::watch(int bus, int address) {
  watched_ = key_of(bus, address);
  left_ = false;
}

bool Usb::wait_for_arrival(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  const bool arrived = changed_.wait_for(lock, timeout, [&] { return arrived_; });
  arrived_ = false;
  return arrived;
}

int Usb::on_hotplug(libusb_context*, libusb_device* device, libusb_hotplug_event event, void* self) {
  Usb& usb = *static_cast<Usb*>(self);
  if (event == LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT) {
    if (key_of(libusb_get_bus_number(device), libusb_get_device_address(device)) == usb.watched_) usb.left_ = true;
    return 0;
  }
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != 0 || !is_kinect(descriptor)) return 0;
  const std::lock_guard lock(usb.mutex_);
  usb.arrived_ = true;
  usb.changed_.notify_all();
  return 0;  // keep listening
}

}  // namespace onemap::hal::libusb
