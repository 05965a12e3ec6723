#include "hal/device_clock.hpp"

#include <algorithm>

namespace onemap::hal {

FrameTime DeviceClock::at(Duration stamp) {
  if (back_ && any_ && FrameTime(stamp + offset_) <= last_) offset_ = last_.time_since_epoch() + away_ - stamp;
  back_ = false;
  const FrameTime time(stamp + offset_);
  last_ = any_ ? std::max(last_, time) : time;
  any_ = true;
  return time;
}

void DeviceClock::came_back(Duration away) {
  constexpr Duration kLeast =
      std::chrono::milliseconds(100);  // what came before and what comes after are not one frame
  back_ = true;
  away_ = std::max(away, kLeast);
}

}  // namespace onemap::hal
