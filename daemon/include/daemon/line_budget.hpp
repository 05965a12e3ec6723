#pragma once
#include "hal/base/time.hpp"

namespace onemap::daemon {

// How many lines may go into a log: many at once, few a second in the long run.
class LineBudget {
 public:
  static constexpr double kAtOnce = 500, kEverySecond = 20;

  // Whether a line may go out now. left_out: so many before it did not; only told when it may.
  bool take(Instant now, unsigned& left_out);

 private:
  double left_ = kAtOnce;
  Instant last_{};
  bool used_ = false;
  unsigned left_out_ = 0;
};

// How often a line that is about the same again and again may go into a log: at first every second, and while it goes
// on every two, four, ... kMost seconds.
class RepeatBudget {
 public:
  static constexpr Duration kLeast = std::chrono::seconds(1), kMost = std::chrono::seconds(16);

  bool take(Instant now, unsigned& left_out);  // as LineBudget's

 private:
  Instant last_{};
  Duration pause_{};
  bool used_ = false;
  unsigned left_out_ = 0;
};

}  // namespace onemap::daemon
