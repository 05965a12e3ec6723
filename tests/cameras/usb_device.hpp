#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "usb_port.hpp"

namespace onemap::test {

using Bytes = std::vector<std::uint8_t>;
using Moment = std::chrono::steady_clock::time_point;

// The eight bytes before a control transfer.
struct Setup {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

// A device on a port: it answers the requests that every device answers, and keeps those of its streams until it has
// something for them.
class UsbDevice {
 public:
  virtual ~UsbDevice() = default;
  void plug(UsbPort& port);
  // One request of the kernel, and then what is due.
  void handle(const UsbPort::Request& request, UsbPort& port);
  virtual void step(Moment now, UsbPort& port) = 0;
  virtual Moment next_step() const = 0;
  // As sysfs has them: the device's and its configuration's.
  Bytes descriptors(UsbPort::Speed speed) const;

 protected:
  virtual Bytes device_descriptor(UsbPort::Speed speed) const = 0;
  virtual Bytes configuration(UsbPort::Speed speed) const = 0;
  virtual std::string text(int index) const = 0;
  // A request of the device's own; nothing: it does not know it. For OUT the answer's bytes do not count.
  virtual std::optional<Bytes> control(const Setup& setup, std::span<const std::uint8_t> out) = 0;
  virtual void forget() = 0;               // it was plugged in: nothing is set yet
  virtual void stopped(int endpoint) = 0;  // nobody wants this stream any more

  std::deque<Urb>& waiting(int endpoint) { return waiting_[endpoint]; }
  UsbPort::Speed speed() const { return speed_; }

 private:
  std::optional<Bytes> standard(const Setup& setup) const;
  std::optional<Bytes> descriptor(const Setup& setup) const;
  void answer_control(const Urb& urb, UsbPort& port);
  void take_back(const UsbPort::Request& request, UsbPort& port);

  UsbPort::Speed speed_ = UsbPort::Speed::high;
  std::map<int, std::deque<Urb>> waiting_;
};

// Little endian, as USB has it.
void put16(Bytes& into, unsigned value);
void put32(Bytes& into, std::uint32_t value);
void append(Bytes& into, const Bytes& more);

}  // namespace onemap::test
