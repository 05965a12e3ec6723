#include "session/replay_window.hpp"

namespace onemap::comms {

ReplayWindow::Verdict ReplayWindow::accept(std::uint64_t counter) {
  if (!any_) {
    any_ = true;
    highest_ = counter;
    seen_[counter % kWindow] = true;
    meter_.begin(counter);
    return Verdict::fresh;
  }
  if (counter > highest_) {
    if (counter - highest_ >= kWindow)
      seen_.reset();
    else
      for (std::uint64_t c = highest_ + 1; c != counter; ++c) seen_[c % kWindow] = false;
    highest_ = counter;
    seen_[counter % kWindow] = true;
    meter_.newest(counter);
    return Verdict::fresh;
  }
  if (highest_ - counter >= kWindow) return Verdict::too_old;
  if (seen_[counter % kWindow]) return Verdict::duplicate;
  seen_[counter % kWindow] = true;
  meter_.overtaken(counter);
  return Verdict::fresh;
}

}  // namespace onemap::comms
