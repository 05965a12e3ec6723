#pragma once
#include <fmt/format.h>

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "hal/base/time.hpp"

namespace onemap::daemon {

// Lines on stderr, `NAME: message`, whole lines from any thread. Whatever a message quotes is made printable: no peer,
// file or device can forge a line or move the cursor.
class Log {
 public:
  explicit Log(std::string name) : name_(std::move(name)) {}

  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    write(fmt::format(format, std::forward<Args>(args)...));
  }
  // At most one line a second for each topic; the next one says how many were left out. False: left out.
  template <class... Args>
  bool limited(std::string_view topic, fmt::format_string<Args...> format, Args&&... args) {
    return write_limited(topic, fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  struct Topic {
    Instant last{};
    unsigned left_out = 0;
    bool used = false;
  };
  void write(std::string_view message);
  bool write_limited(std::string_view topic, std::string_view message);
  const std::string name_;
  std::mutex mutex_;
  std::map<std::string, Topic, std::less<>> topics_;
};

}  // namespace onemap::daemon
