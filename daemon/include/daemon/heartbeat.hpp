#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "hal/base/time.hpp"

namespace onemap::daemon {

// A thread's sign that it gets on. It beats while it works, at least once within its patience, and rests while it waits
// for work that may never come. Who neither beats nor rests is stuck: in a driver, in a lock, in a loop.
class Heartbeat {
 public:
  Heartbeat(std::string name, Duration patience) : name_(std::move(name)), patience_(patience) {}

  void beat(Instant now) { at_ns_ = now.time_since_epoch().count(); }
  void rest() { at_ns_ = kRests; }

  // Any thread.
  bool stuck(Instant now) const {
    const std::int64_t at = at_ns_;
    return at != kRests && (now.time_since_epoch() - Duration(at)) > patience_;
  }
  const std::string& name() const { return name_; }
  Duration patience() const { return patience_; }

 private:
  static constexpr std::int64_t kRests = INT64_MIN;
  const std::string name_;
  const Duration patience_;
  std::atomic<std::int64_t> at_ns_ = kRests;
};

}  // namespace onemap::daemon
