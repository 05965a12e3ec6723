#include "trickle.hpp"

#include <algorithm>

namespace onemap::comms {

void Trickle::changed(Instant now, Duration gap) {
  interval_ = shortest_;
  at_ = std::min(at_, std::max(now, last_ + gap));
}

void Trickle::said(Instant now, Duration at_most, SplitMix& random) {
  const auto half = static_cast<std::uint64_t>(std::min(interval_, at_most).count() / 2);
  last_ = now;
  at_ = now + Duration(static_cast<std::int64_t>(half + random.next() % (half + 1)));
  interval_ = std::min(interval_ * 2, longest_);
}

}  // namespace onemap::comms
