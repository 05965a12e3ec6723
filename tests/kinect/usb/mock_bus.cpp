#include "mock_bus.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mock_port.hpp"

namespace onemap::test {

namespace {

const char* megabits(UsbPort::Speed speed) {
  return speed == UsbPort::Speed::full ? "12" : speed == UsbPort::Speed::high ? "480" : "5000";
}

}  // namespace

MockBus::MockBus() : testbed_(umockdev_testbed_new()) {}

MockBus::~MockBus() {
  plugged_.clear();
  g_object_unref(testbed_);
}

MockBus::Plugged* MockBus::at(int socket) {
  for (Plugged& one : plugged_)
    if (one.socket == socket && one.present) return &one;
  return nullptr;
}

void MockBus::plug(int socket, UsbDevice& device, UsbPort::Speed speed) {
  const std::size_t number = plugged_.size() + 2;
  const std::string node = fmt::format("/dev/bus/usb/001/{:03}", number);
  std::string hex;
  for (const std::uint8_t byte : device.descriptors(speed)) hex += fmt::format("{:02X}", byte);
  const std::string text = fmt::format(
      "P: /devices/usb1/1-{0}\nN: {1}\nE: DEVNAME={2}\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nE: BUSNUM=001\n"
      "E: DEVNUM={3:03}\nA: busnum=1\\n\nA: devnum={3}\\n\nA: speed={4}\\n\nA: bConfigurationValue=1\\n\n"
      "H: descriptors={5}\n",
      socket, node.substr(5), node, number, megabits(speed), hex);
  GError* error = nullptr;
  if (!umockdev_testbed_add_from_string(testbed_, text.c_str(), &error))
    throw std::runtime_error(std::string("umockdev: ") + (error ? error->message : ""));
  gchar* root = umockdev_testbed_get_root_dir(testbed_);
  plugged_.push_back({socket, std::make_unique<MockPort>(device, speed, root + node)});
  g_free(root);
  plugged_.back().port->attach(testbed_, node);
  umockdev_testbed_uevent(testbed_, fmt::format("/sys/devices/usb1/1-{}", socket).c_str(), "add");
}

void MockBus::unplug(int socket) {
  Plugged* one = at(socket);
  if (!one) return;
  one->present = false;
  one->port->pull_out();
  const std::string path = fmt::format("/sys/devices/usb1/1-{}", socket);
  umockdev_testbed_uevent(testbed_, path.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_, path.c_str());
}

void MockBus::pull_out_at(int socket, int request) {
  if (Plugged* one = at(socket)) one->port->pull_out_at(request);
}

void MockBus::step(int socket) {
  if (Plugged* one = at(socket)) one->port->step();
}

}  // namespace onemap::test
