#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::hal {

// What became of a depth camera on USB.
struct UsbNews {
  enum class What : std::uint8_t { came, left, reset } what = What::came;
  std::string camera;   // who it is and where: "Intel RealSense 8086:0b07, USB bus 2 port 1"
  std::string problem;  // what its port is too slow for; empty: nothing
  std::string text() const;
};

// Hears by libusb of the depth cameras of all backends, known by their makers' numbers, that come to this machine's USB
// and leave it, whether one of them is used or not. One that comes back where it was, within a few seconds, was reset
// by the kernel or by a loose plug. One thread asks.
class UsbWatch {
 public:
  // The error says why this machine does not tell, for example without udev's daemon in a container.
  static Result<std::unique_ptr<UsbWatch>> start();
  ~UsbWatch();
  UsbWatch(const UsbWatch&) = delete;
  UsbWatch& operator=(const UsbWatch&) = delete;

  // What happened since it was last asked; now, by a clock that only goes on. Does not wait.
  std::vector<UsbNews> news(Instant now);

 private:
  struct Parts;
  explicit UsbWatch(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace onemap::hal
