#include "session/receive_window.hpp"

#include <algorithm>

namespace onemap::comms {

namespace {
constexpr std::uint64_t kFirstRound = std::uint64_t{1} << 32;  // so that what is older than the first has a number, too

std::uint64_t unfold(std::uint32_t counter, std::uint64_t near) {
  const auto ahead = static_cast<std::int32_t>(counter - static_cast<std::uint32_t>(near));
  return near + static_cast<std::uint64_t>(std::int64_t{ahead});
}
}  // namespace

ReceiveWindow::Arrival ReceiveWindow::accept(std::uint32_t counter) {
  if (highest_ == 0) {
    anchor(kFirstRound + counter);
    return {Verdict::fresh, highest_};
  }
  const std::uint64_t at = unfold(counter, highest_);
  const std::uint64_t distance = at > highest_ ? at - highest_ : highest_ - at;
  if (distance >= kWindow) {
    if (elsewhere_ && at > *elsewhere_ && at - *elsewhere_ <= kNear) {
      anchor(at);
      return {Verdict::fresh, at};
    }
    elsewhere_ = at;
    return {at > highest_ ? Verdict::jump : Verdict::too_old, at};
  }
  if (at > highest_) {
    advance(at);
    return {Verdict::fresh, at};
  }
  if (seen_[at % kWindow]) return {Verdict::duplicate, at};
  seen_[at % kWindow] = true;
  if (at > block_start_) ++received_in_block_;
  return {Verdict::fresh, at};
}

// What was sent before we listened is not lost.
void ReceiveWindow::anchor(std::uint64_t at) {
  seen_.reset();
  elsewhere_.reset();
  seen_[at % kWindow] = true;
  highest_ = at;
  block_start_ = at - 1;
  received_in_block_ = 1;
}

void ReceiveWindow::advance(std::uint64_t at) {
  for (std::uint64_t c = highest_ + 1; c != at; ++c) seen_[c % kWindow] = false;
  highest_ = at;
  seen_[at % kWindow] = true;
  ++received_in_block_;
  if (highest_ - block_start_ >= kBlock) count_block();
}

void ReceiveWindow::count_block() {
  const auto expected = static_cast<double>(highest_ - block_start_);
  const double lost = std::max(0.0, 1.0 - static_cast<double>(received_in_block_) / expected);
  loss_ = measured_ ? 0.75 * loss_ + 0.25 * lost : lost;
  measured_ = true;
  block_start_ = highest_;
  received_in_block_ = 0;
}

}  // namespace onemap::comms
