#include "rate/queue_delay.hpp"

#include <algorithm>

namespace onemap::comms {

using std::chrono::microseconds;
using std::chrono::milliseconds;

namespace {
constexpr Duration kEmpty = milliseconds(1);      // so near to the base, the queue was empty
constexpr Duration kShorter = microseconds(300);  // less is noise
constexpr Duration kFlat = milliseconds(20);      // no shorter for this long: there is nothing left to drain
constexpr Duration kLongestDrain = milliseconds(400);
}  // namespace

void QueueDelay::sample(Instant now, Duration clock_difference) {
  before_ = samples_ == 0 ? clock_difference : last_;
  last_ = clock_difference;
  if (samples_++ == 0 || clock_difference < base_) base_ = clock_difference;
  if (clock_difference <= base_ + kEmpty) empty_ = now;
  if (!drain_) return;
  if (clock_difference >= drain_->lowest - kShorter) {
    if (now > drain_->shows) ++drain_->no_shorter;
    return;
  }
  drain_->no_shorter = 0;
  drain_->lowest = clock_difference;
  drain_->lowest_at = std::max(now, drain_->shows);
}

Duration QueueDelay::queue() const { return std::min(last_, before_) - base_; }

void QueueDelay::begin_drain(Instant now, Duration round_trip) {
  drain_ = Drain{now, now + round_trip, now + round_trip, last_, 0};
}

bool QueueDelay::drained(Instant now) const {
  if (!drain_) return false;
  return (drain_->no_shorter >= 2 && now - drain_->lowest_at >= kFlat) || drains_too_long(now);
}

bool QueueDelay::drains_too_long(Instant now) const { return drain_ && now - drain_->began >= kLongestDrain; }

// A way that became longer is believed after half a minute: another sender may have filled the queue while we drained.
void QueueDelay::end_drain(Instant now) {
  if (drains_ > 0 && now - counted_ < kOneDrain) {
    Duration& last = lowest_[(drains_ - 1) % kDrains];
    last = std::min(last, drain_->lowest);
  } else {
    lowest_[drains_++ % kDrains] = drain_->lowest;
    counted_ = now;
  }
  drain_.reset();
  empty_ = now;
  if (drains_ >= kDrains) base_ = *std::min_element(lowest_.begin(), lowest_.end());
}

}  // namespace onemap::comms
