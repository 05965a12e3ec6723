#pragma once
#include "hal/base/time.hpp"

namespace onemap::hal {

// A device's stamps, counted from a start of its own, as times that go on when the device comes back: with a clock that
// started again, time continues after what was waited; with one that went on, nothing is changed.
class DeviceClock {
 public:
  explicit DeviceClock(Duration offset) : offset_(offset) {}

  FrameTime at(Duration stamp);
  // The device comes back after `away`, as far as it is known.
  void came_back(Duration away);

 private:
  Duration offset_;
  FrameTime last_{};  // the latest that was given
  bool any_ = false, back_ = false;
  Duration away_{};
};

}  // namespace onemap::hal
