#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "daemon/line_budget.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// syslog's priorities, as far as we have them.
enum class Level : std::uint8_t {
  error = 3,    // the work ends, or a part of it
  warning = 4,  // somebody should do something
  info = 6,     // a state changed
};

// Lines on stderr, `NAME: message`, whole lines from any thread; into systemd's journal with their priority in front
// (sd-daemon(3)). Whatever a message quotes is made printable: no peer, file or device can forge a line or move the
// cursor. Many lines at once are let out, but few a second for long; how many were not is said later. Errors always
// are.
class Log {
 public:
  explicit Log(std::string name);

  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    write(Level::info, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void warn(fmt::format_string<Args...> format, Args&&... args) {
    write(Level::warning, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  void error(fmt::format_string<Args...> format, Args&&... args) {
    write(Level::error, fmt::format(format, std::forward<Args>(args)...));
  }
  // At most one line a second for each topic, fewer while it goes on (RepeatBudget); the next one says how many were
  // left out. False: left out.
  template <class... Args>
  bool limited(std::string_view topic, fmt::format_string<Args...> format, Args&&... args) {
    return write_limited(Level::warning, topic, fmt::format(format, std::forward<Args>(args)...));
  }
  template <class... Args>
  bool limited(Level level, std::string_view topic, fmt::format_string<Args...> format, Args&&... args) {
    return write_limited(level, topic, fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  void write(Level level, std::string_view message);
  void put(Level level, std::string_view message) const;
  bool write_limited(Level level, std::string_view topic, std::string_view message);
  const std::string name_;
  const bool journal_;  // stderr is the journal's
  std::mutex mutex_;
  std::map<std::string, RepeatBudget> topics_;
  LineBudget budget_;
};

// Whether JOURNAL_STREAM ("device:inode") says that this descriptor goes to systemd's journal.
bool is_journal(int descriptor, const char* journal_stream);

}  // namespace onemap::daemon
