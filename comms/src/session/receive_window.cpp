#include "session/receive_window.hpp"

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
  meter_.overtaken(at);
  return {Verdict::fresh, at};
}

// What was sent before we listened is not lost.
void ReceiveWindow::anchor(std::uint64_t at) {
  seen_.reset();
  elsewhere_.reset();
  seen_[at % kWindow] = true;
  highest_ = at;
  meter_.begin(at);
}

void ReceiveWindow::advance(std::uint64_t at) {
  for (std::uint64_t c = highest_ + 1; c != at; ++c) seen_[c % kWindow] = false;
  highest_ = at;
  seen_[at % kWindow] = true;
  meter_.newest(at);
}

}  // namespace onemap::comms
