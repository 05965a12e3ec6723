#include "daemon/log.hpp"

#include <cstdio>
#include <utility>

#include "daemon/clock.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

void Log::write(std::string_view message) {
  // One fwrite: lines of several processes that share a terminal do not mix.
  const std::string line = fmt::format("{}: {}\n", name_, printable(message));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

bool Log::write_limited(std::string_view topic, std::string_view message) {
  unsigned left_out = 0;
  {
    const std::lock_guard lock(mutex_);
    Topic& entry = topics_.try_emplace(std::string(topic)).first->second;
    const Instant t = now();
    if (entry.used && t - entry.last < std::chrono::seconds(1)) {
      ++entry.left_out;
      return false;
    }
    left_out = std::exchange(entry.left_out, 0u);
    entry.used = true;
    entry.last = t;
  }
  write(left_out == 0 ? std::string(message) : fmt::format("{} ({} like it left out)", message, left_out));
  return true;
}

}  // namespace onemap::daemon
