#pragma once
#include "hal/base/time.hpp"

namespace onemap::daemon {

// SIGTERM and SIGINT as something to wait for, for the rest of the program. Make it before any thread starts: they
// inherit the blocked signals.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // True as soon as one came, and from then on; false after at_most.
  bool wait(Duration at_most);

 private:
  int descriptor_ = -1;
  bool stopped_ = false;
};

}  // namespace onemap::daemon
