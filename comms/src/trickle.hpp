#pragma once
#include "hal/base/splitmix.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

// When to say something to everybody (after RFC 6206): the interval doubles while nothing changes, the moment is random
// in its second half, and a change makes it short again and due at once, though not sooner than `gap` after the last.
class Trickle {
 public:
  Trickle(Duration shortest, Duration longest) : shortest_(shortest), longest_(longest), interval_(shortest) {}
  void changed(Instant now, Duration gap = std::chrono::milliseconds(100));
  bool due(Instant now) const { return at_ <= now; }
  // It was said now; the next interval is not longer than `at_most`.
  void said(Instant now, Duration at_most, SplitMix& random);
  bool quiet() const { return interval_ >= longest_; }  // nothing has changed for a while
  Instant next() const { return at_; }

 private:
  Duration shortest_, longest_, interval_;
  Instant at_{}, last_{};
};

}  // namespace onemap::comms
