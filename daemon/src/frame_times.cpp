#include "daemon/frame_times.hpp"

namespace onemap::daemon {

FrameTimes::Verdict FrameTimes::take(FrameTime& colour, FrameTime& depth) {
  Verdict verdict = Verdict::good;
  if (shift_ != Duration::zero() && colour > last_) {
    shift_ = Duration::zero();
    verdict = Verdict::returned;
  }
  if (colour + shift_ <= last_) {
    in_a_row_ = colour > refused_at_ ? in_a_row_ + 1 : 1;
    const Duration step = colour - refused_at_;
    refused_at_ = colour;
    if (in_a_row_ <= kPatience) {
      ++refused_;
      return Verdict::refused;
    }
    shift_ = last_ + step - colour;
    verdict = Verdict::moved;
  }
  in_a_row_ = 0;
  refused_at_ = FrameTime::min();
  colour += shift_;
  depth += shift_;
  last_ = colour;
  return verdict;
}

}  // namespace onemap::daemon
