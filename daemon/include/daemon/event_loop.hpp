#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// One thread's epoll loop: descriptors, timers, and what other threads hand in. Whatever is called from it must not
// wait. All but post(), stop() and ringing belong to the thread that runs it.
class EventLoop {
 public:
  using Id = std::uint64_t;                                     // of something watched; never used again
  using Ready = std::function<void(std::uint32_t)>;             // EPOLLIN, EPOLLOUT, EPOLLHUP, ...
  static constexpr std::uint32_t kReadable = 1, kWritable = 4;  // EPOLLIN, EPOLLOUT

  static Result<std::unique_ptr<EventLoop>> open();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  // Calls ready() while one of the events is there (level triggered). The descriptor stays the caller's, who forgets
  // it before closing it. A callback may forget anything, itself included.
  Result<Id> watch(int descriptor, std::uint32_t events, Ready ready);
  void change(Id id, std::uint32_t events);
  void forget(Id id);
  // Calls tick() again and again; however late the loop is (the process was stopped), missed ticks are one.
  Result<Id> every(Duration interval, std::function<void()> tick);
  void post(std::function<void()> task);  // any thread: run on the loop's, soon
  // Something that any thread rings, without waiting or memory; however often before the loop comes to it, it is once.
  class Bell {
   public:
    void ring() const;

   private:
    friend class EventLoop;
    explicit Bell(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
  };
  Result<Bell> bell(std::function<void()> rung);  // good as long as the loop

  void run();   // until stop(); what was asked before is done first
  void stop();  // any thread

 private:
  struct Watch {
    int descriptor = -1;
    Ready ready;
    bool owned = false;  // a timer or a bell of the loop's own
  };
  EventLoop(int epoll, int bell) : epoll_(epoll), bell_(bell) {}
  void dispatch(Id id, std::uint32_t events);
  void run_posted();

  const int epoll_, bell_;
  Id last_ = 0;
  std::map<Id, std::shared_ptr<Watch>> watches_;
  std::mutex mutex_;  // of posted_ and stop_
  std::vector<std::function<void()>> posted_;
  bool stop_ = false;
};

}  // namespace onemap::daemon
