#include "daemon/log.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "daemon/clock.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

bool is_journal(int descriptor, const char* journal_stream) {
  struct stat stream {};
  if (journal_stream == nullptr || fstat(descriptor, &stream) != 0) return false;
  return fmt::format("{}:{}", stream.st_dev, stream.st_ino) == journal_stream;
}

Log::Log(std::string name)
    : name_(std::move(name)), journal_(is_journal(STDERR_FILENO, std::getenv("JOURNAL_STREAM"))) {}

// One fwrite: lines of several processes that share a terminal do not mix.
void Log::put(Level level, std::string_view message) const {
  const std::string priority = journal_ ? fmt::format("<{}>", static_cast<int>(level)) : "";
  const std::string line = fmt::format("{}{}: {}\n", priority, name_, printable(message));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

void Log::write(Level level, std::string_view message) {
  unsigned left_out = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!budget_.take(now(), left_out) && level != Level::error) return;
  }
  if (left_out > 0)
    put(Level::warning,
        fmt::format("{} lines were left out here: more than {:.0f} a second", left_out, LineBudget::kEverySecond));
  put(level, message);
}

bool Log::write_limited(Level level, std::string_view topic, std::string_view message) {
  unsigned left_out = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!topics_[std::string(topic)].take(now(), left_out)) return false;
  }
  write(level, left_out == 0 ? std::string(message) : fmt::format("{} ({} like it left out)", message, left_out));
  return true;
}

}  // namespace onemap::daemon
