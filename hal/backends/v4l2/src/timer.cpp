#include "timer.hpp"

#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace onemap::hal::v4l2 {

Result<Timer> Timer::create() {
  const int fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  if (fd < 0) return Error{"v4l2", std::string("no timer: ") + std::strerror(errno)};
  return Timer(fd);
}

Timer::Timer(Timer&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Timer::~Timer() {
  if (fd_ >= 0) close(fd_);
}

void Timer::start(std::chrono::milliseconds after) {
  const std::int64_t ns = std::max<std::int64_t>(1, std::chrono::nanoseconds(after).count());  // 0 would stop it
  itimerspec spec{};
  spec.it_value.tv_sec = ns / 1'000'000'000;
  spec.it_value.tv_nsec = ns % 1'000'000'000;
  timerfd_settime(fd_, 0, &spec, nullptr);
}

bool Timer::over() const {
  pollfd one{fd_, POLLIN, 0};
  return poll(&one, 1, 0) == 1;
}

}  // namespace onemap::hal::v4l2
