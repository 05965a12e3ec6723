#pragma once
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::daemon {

// The only place that reads a clock; everything below the daemon takes `now` as an argument.
Instant now();

// Of the configuration: its times are seconds.
constexpr Duration seconds(double s) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s)); }

// Processor time of the calling thread: what a frame costs, whatever else runs on the machine.
Duration thread_cpu_time();

// Nanoseconds since 1970: tells one life of this robot from the next, nothing else.
std::uint64_t wall_clock_ns();

// What turns the monotonic clock's time into time since 1970, now: a live camera's stamps are monotonic.
Duration wall_clock_offset();

// Peak resident memory of this process so far (VmHWM), MiB.
double peak_rss_mb();
double rss_mb();  // now (VmRSS)

}  // namespace onemap::daemon
