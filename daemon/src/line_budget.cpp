#include "daemon/line_budget.hpp"

#include <algorithm>
#include <utility>

namespace onemap::daemon {

bool LineBudget::take(Instant now, unsigned& left_out) {
  if (used_) left_ = std::min(kAtOnce, left_ + kEverySecond * std::max(0.0, to_seconds(now - last_)));
  used_ = true;
  last_ = now;
  left_out = 0;
  if (left_ < 1) {
    ++left_out_;
    return false;
  }
  left_ -= 1;
  left_out = std::exchange(left_out_, 0u);
  return true;
}

bool RepeatBudget::take(Instant now, unsigned& left_out) {
  left_out = 0;
  if (used_ && now - last_ < pause_) {
    ++left_out_;
    return false;
  }
  const bool goes_on = used_ && now - last_ < 2 * pause_;
  pause_ = goes_on ? std::min(2 * pause_, kMost) : kLeast;
  used_ = true;
  last_ = now;
  left_out = std::exchange(left_out_, 0u);
  return true;
}

}  // namespace onemap::daemon
