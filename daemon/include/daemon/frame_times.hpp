#pragma once
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::daemon {

// What follows needs times that increase; a camera whose clock was set back does not give them. Its frames are refused
// at first; when it goes on from there, its times are moved to where they were, until they are ahead by themselves
// again. Pure.
class FrameTimes {
 public:
  static constexpr int kPatience = 10;  // frames that are refused before times are moved

  enum class Verdict {
    good,      // nothing is wrong
    refused,   // not after the last one
    moved,     // from this frame on times are moved by shift()
    returned,  // from this frame on they are not, any more
  };
  // The times of a frame, moved where that is due. What is refused stays as it is.
  Verdict take(FrameTime& colour, FrameTime& depth);
  Duration shift() const { return shift_; }
  std::uint64_t refused() const { return refused_; }

 private:
  FrameTime last_ = FrameTime::min();        // that was good, moved
  FrameTime refused_at_ = FrameTime::min();  // the last one that was refused, as it came
  int in_a_row_ = 0;
  Duration shift_{};
  std::uint64_t refused_ = 0;
};

}  // namespace onemap::daemon
