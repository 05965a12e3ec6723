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

}  // namespace onemap::daemon
