#include "link.hpp"

#include <algorithm>

namespace onemap::comms {

using std::chrono::milliseconds;

ReceiveWindow::Verdict ReceiveWindow::accept(std::uint32_t counter) {
  if (counter <= highest_) {
    if (highest_ - counter >= kWindow) return Verdict::too_old;
    if (seen_[counter % kWindow]) return Verdict::duplicate;
    seen_[counter % kWindow] = true;
    if (counter > block_start_) ++received_in_block_;
    return Verdict::fresh;
  }
  if (counter - highest_ >= kWindow) {
    seen_.reset();
  } else {
    for (std::uint32_t c = highest_ + 1; c != counter; ++c) seen_[c % kWindow] = false;
  }
  if (highest_ == 0) block_start_ = counter - 1;  // what was sent before we listened is not lost
  highest_ = counter;
  seen_[counter % kWindow] = true;
  ++received_in_block_;
  if (highest_ - block_start_ >= kBlock) count_block();
  return Verdict::fresh;
}

void ReceiveWindow::count_block() {
  const double expected = highest_ - block_start_;
  const double lost = std::max(0.0, 1.0 - received_in_block_ / expected);
  loss_ = measured_ ? 0.75 * loss_ + 0.25 * lost : lost;
  measured_ = true;
  block_start_ = highest_;
  received_in_block_ = 0;
}

void RoundTrip::sample(Duration rtt) {
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

std::size_t Link::outstanding() const {
  std::size_t sum = 0;
  for (const AskLane& lane : lanes) sum += lane.outstanding;
  return sum;
}

void Link::forget_peer() {
  Link fresh;
  fresh.endpoint = endpoint;
  fresh.configured = configured;
  fresh.next_counter = next_counter;
  fresh.bytes_in = bytes_in;
  fresh.bytes_out = bytes_out;
  *this = std::move(fresh);
}

}  // namespace onemap::comms
