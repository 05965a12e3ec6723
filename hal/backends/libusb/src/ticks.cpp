#include "hal/backends/libusb/ticks.hpp"

namespace onemap::hal::libusb {

Duration Ticks::at(std::uint32_t ticks) {
  // Unsigned arithmetic turns with the counter; the difference is small in either direction.
  total_ += any_ ? static_cast<std::int64_t>(static_cast<std::int32_t>(ticks - last_)) : std::int64_t{ticks};
  any_ = true;
  last_ = ticks;
  return Duration(total_ * 50 / 3);
}

}  // namespace onemap::hal::libusb
