#pragma once
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::hal::libusb {

// A Kinect's stamps: a 60 MHz counter of 32 bits that starts again every 71.6 s. Continued from the first stamp, for
// the images of both streams in their order of arrival, at most half a turn apart.
class Ticks {
 public:
  Duration at(std::uint32_t ticks);

 private:
  bool any_ = false;
  std::uint32_t last_ = 0;
  std::int64_t total_ = 0;
};

}  // namespace onemap::hal::libusb
