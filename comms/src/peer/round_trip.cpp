#include "peer/round_trip.hpp"

#include <algorithm>

namespace onemap::comms {

using std::chrono::milliseconds;

// Who was stopped for a while, or cut off, answers once and very late: that must not make everybody wait for seconds. A
// way that is as long as that, or has become so, says it with the next samples again.
void RoundTrip::sample(Duration rtt) {
  rtt = std::min(rtt, std::max<Duration>(milliseconds(200), 2 * give_up_after(0)));
  if (srtt_.count() == 0) {
    srtt_ = std::max(rtt, Duration(1));
    var_ = rtt / 2;
    return;
  }
  hasty_ -= hasty_ / 16;
  const Duration error = rtt > srtt_ ? rtt - srtt_ : srtt_ - rtt;
  var_ = (3 * var_ + error) / 4;
  srtt_ = std::max((7 * srtt_ + rtt) / 8, Duration(1));
}

// Silence may be plain loss (half of all questions and answers at 30 % each way), so patience grows slowly at first.
Duration RoundTrip::give_up_after(unsigned silences) const {
  constexpr unsigned kMost = 10;
  Duration base = milliseconds(100);
  if (srtt_.count() != 0) base = srtt_ + std::max<Duration>(4 * var_, milliseconds(10));
  base = std::clamp<Duration>(base, milliseconds(30), milliseconds(2000));
  if (silences > kPatientSilences) base *= 1u << (std::min(silences, kMost) - kPatientSilences);
  return std::min<Duration>(base, milliseconds(2000));
}

Duration RoundTrip::reorder_window() const {
  return (srtt_.count() == 0 ? milliseconds(20) : std::max<Duration>(milliseconds(2), 4 * var_)) + hasty_;
}

void RoundTrip::was_hasty() { hasty_ = std::min<Duration>(hasty_ + milliseconds(1), milliseconds(200)); }

}  // namespace onemap::comms
