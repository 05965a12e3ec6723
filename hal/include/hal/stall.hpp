#pragma once
#include <chrono>

namespace onemap::hal {

// Whether a live stream has stalled though its device is still there, as after a reset of USB that nobody was told of.
// It reads no clock: the waits that brought nothing are summed.
class Stall {
 public:
  static constexpr std::chrono::milliseconds kAfter{5000};

  void came() { silent_ = {}; }  // a frame, or anything else that shows that the device lives
  // A wait of this length brought nothing. True when the stream has stalled; the sum then begins anew.
  bool waited(std::chrono::milliseconds time) {
    silent_ += time;
    if (silent_ < kAfter) return false;
    silent_ = {};
    return true;
  }

 private:
  std::chrono::milliseconds silent_{};
};

}  // namespace onemap::hal
