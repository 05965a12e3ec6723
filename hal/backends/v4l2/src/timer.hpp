#pragma once
#include <chrono>

#include "hal/base/result.hpp"

namespace onemap::hal::v4l2 {

// The kernel's alarm as a file descriptor that poll() waits for beside others: a time limit over several waits without
// reading a clock.
class Timer {
 public:
  static Result<Timer> create();
  Timer(Timer&& other) noexcept;
  Timer& operator=(Timer&&) = delete;
  ~Timer();

  void start(std::chrono::milliseconds after);  // at once when it is 0 or less
  bool over() const;
  int fd() const { return fd_; }

 private:
  explicit Timer(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace onemap::hal::v4l2
