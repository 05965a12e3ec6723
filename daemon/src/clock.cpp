#include "daemon/clock.hpp"

#include <ctime>
#include <sstream>
#include <string>

#include "hal/base/file.hpp"

namespace onemap::daemon {

namespace {
// A size of this process, MiB.
double of_own_status(const std::string& field) {
  const auto text = read_text_file("/proc/self/status", kSmallFileBytes);
  if (!text) return 0;
  std::istringstream status(*text);
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(field)) return std::stod(line.substr(field.size())) / 1024.0;
  return 0;
}
}  // namespace

namespace {
Duration read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
}
}  // namespace

Instant now() { return Instant(read_clock(CLOCK_MONOTONIC)); }

Duration thread_cpu_time() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

std::uint64_t wall_clock_ns() { return static_cast<std::uint64_t>(read_clock(CLOCK_REALTIME).count()); }

Duration wall_clock_offset() { return read_clock(CLOCK_REALTIME) - read_clock(CLOCK_MONOTONIC); }

// Not getrusage: after fork and exec its maximum also holds the parent's size.
double peak_rss_mb() { return of_own_status("VmHWM:"); }

double rss_mb() { return of_own_status("VmRSS:"); }

}  // namespace onemap::daemon
