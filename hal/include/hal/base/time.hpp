#pragma once
#include <chrono>
#include <cstdint>

namespace onemap {

using Duration = std::chrono::nanoseconds;

// The clock of the recording: nanoseconds since the Unix epoch as the camera stamped them. It is data and is never
// "now".
struct FrameClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<FrameClock>;
  static constexpr bool is_steady = false;
};
using FrameTime = FrameClock::time_point;

// Monotonic time of one process. Pure modules take it as an argument; only the daemon reads a clock.
struct MonotonicClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MonotonicClock>;
  static constexpr bool is_steady = true;
};
using Instant = MonotonicClock::time_point;

inline double to_seconds(FrameTime t) { return static_cast<double>(t.time_since_epoch().count()) * 1e-9; }
inline double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
inline FrameTime frame_time_from_ns(std::int64_t ns) { return FrameTime(Duration(ns)); }

}  // namespace onemap
