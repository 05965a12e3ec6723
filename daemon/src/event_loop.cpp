#include "daemon/event_loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace onemap::daemon {

namespace {
constexpr EventLoop::Id kBell = 0;  // the loop's own

Error failed(const char* what) { return {"event loop", std::string(what) + ": " + std::strerror(errno)}; }

bool add(int epoll, int descriptor, std::uint32_t events, EventLoop::Id id) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  return epoll_ctl(epoll, EPOLL_CTL_ADD, descriptor, &event) == 0;
}

timespec timespec_of(Duration duration) {
  const auto ns = duration.count();
  return {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}
}  // namespace

static_assert(EventLoop::kReadable == EPOLLIN && EventLoop::kWritable == EPOLLOUT);

Result<std::unique_ptr<EventLoop>> EventLoop::open() {
  const int epoll = epoll_create1(EPOLL_CLOEXEC);
  if (epoll < 0) return failed("epoll");
  const int bell = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (bell < 0 || !add(epoll, bell, EPOLLIN, kBell)) {
    Error error = failed("eventfd");
    ::close(epoll);
    if (bell >= 0) ::close(bell);
    return error;
  }
  return std::unique_ptr<EventLoop>(new EventLoop(epoll, bell));
}

EventLoop::~EventLoop() {
  for (const auto& [id, watch] : watches_)
    if (watch->owned) ::close(watch->descriptor);
  ::close(bell_);
  ::close(epoll_);
}

Result<EventLoop::Id> EventLoop::watch(int descriptor, std::uint32_t events, Ready ready) {
  const Id id = ++last_;
  if (!add(epoll_, descriptor, events, id)) return failed("epoll");
  watches_.emplace(id, std::make_shared<Watch>(Watch{descriptor, std::move(ready), false}));
  return id;
}

void EventLoop::change(Id id, std::uint32_t events) {
  const auto found = watches_.find(id);
  if (found == watches_.end()) return;
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  (void)epoll_ctl(epoll_, EPOLL_CTL_MOD, found->second->descriptor, &event);  // it is watched: cannot fail
}

void EventLoop::forget(Id id) {
  const auto found = watches_.find(id);
  if (found == watches_.end()) return;
  (void)epoll_ctl(epoll_, EPOLL_CTL_DEL, found->second->descriptor, nullptr);
  if (found->second->owned) ::close(found->second->descriptor);
  watches_.erase(found);
}

Result<EventLoop::Id> EventLoop::every(Duration interval, std::function<void()> tick) {
  const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK);
  if (timer < 0) return failed("timerfd");
  const itimerspec times{timespec_of(interval), timespec_of(interval)};
  (void)timerfd_settime(timer, 0, &times, nullptr);
  auto id = watch(timer, EPOLLIN, [timer, tick = std::move(tick)](std::uint32_t) {
    std::uint64_t ticks = 0;
    if (read(timer, &ticks, sizeof ticks) == sizeof ticks) tick();
  });
  if (!id)
    ::close(timer);
  else
    watches_.at(*id)->owned = true;
  return id;
}

Result<EventLoop::Bell> EventLoop::bell(std::function<void()> rung) {
  const int descriptor = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (descriptor < 0) return failed("eventfd");
  auto id = watch(descriptor, EPOLLIN, [descriptor, rung = std::move(rung)](std::uint32_t) {
    std::uint64_t times = 0;
    if (read(descriptor, &times, sizeof times) == sizeof times) rung();
  });
  if (!id) {
    ::close(descriptor);
    return id.error();
  }
  watches_.at(*id)->owned = true;
  return Bell(descriptor);
}

void EventLoop::Bell::ring() const {
  const std::uint64_t one = 1;
  (void)!write(descriptor_, &one, sizeof one);
}

void EventLoop::post(std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    posted_.push_back(std::move(task));
  }
  Bell(bell_).ring();
}

void EventLoop::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  Bell(bell_).ring();
}

void EventLoop::run_posted() {
  std::uint64_t rung = 0;
  (void)!read(bell_, &rung, sizeof rung);
  std::vector<std::function<void()>> tasks;
  {
    const std::lock_guard lock(mutex_);
    tasks = std::exchange(posted_, {});
  }
  for (const auto& task : tasks) task();
}

void EventLoop::dispatch(Id id, std::uint32_t events) {
  if (id == kBell) return run_posted();
  const auto found = watches_.find(id);
  if (found == watches_.end()) return;                // forgotten by a callback before
  const std::shared_ptr<Watch> keep = found->second;  // it may forget itself
  keep->ready(events);
}

void EventLoop::run() {
  std::array<epoll_event, 64> events{};
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(stop_, false)) return;
    }
    const int count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), -1);
    for (int i = 0; i < count; ++i)
      dispatch(events[static_cast<std::size_t>(i)].data.u64, events[static_cast<std::size_t>(i)].events);
  }
}

}  // namespace onemap::daemon
