#pragma once
#include <optional>

#include "hal/base/time.hpp"

namespace onemap::daemon {

// What the end of a terminal (SIGHUP) is for a program.
enum class Hangup : bool { ends, reloads };

// SIGTERM and SIGINT, and with Hangup::reloads SIGHUP, as something to wait for, for the rest of the program. Make it
// before any thread starts: they inherit the blocked signals.
class StopSignals {
 public:
  explicit StopSignals(Hangup hangup = Hangup::ends);
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // True as soon as one that stops came, and from then on; false after at_most.
  bool wait(Duration at_most);

  int descriptor() const { return descriptor_; }  // readable while one is there
  std::optional<int> take();                      // the next one's number, without waiting

 private:
  int descriptor_ = -1;
  bool stopped_ = false;
};

}  // namespace onemap::daemon
