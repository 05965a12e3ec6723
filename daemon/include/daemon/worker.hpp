#pragma once
#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "hal/base/result.hpp"

namespace onemap::daemon {

// Why the work cannot go on: the first thing that a thread could not handle. Thread safe.
class Failures {
 public:
  void add(std::string_view thread, std::string_view what);
  bool any() const { return any_; }
  std::string first() const;  // "THREAD: WHAT"; empty when there is none

 private:
  mutable std::mutex mutex_;
  std::string first_;
  std::atomic<bool> any_ = false;
};

// A thread whose exceptions are reported instead of ending the process, so that what there is can still be written.
class Worker {
 public:
  Worker() = default;
  ~Worker() { join(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Runs body, and then, whether or not it threw, at_end (which must not throw): what others wait for is released
  // there.
  void start(std::string name, Failures& failures, std::function<void()> body, std::function<void()> at_end = {});
  void join();

 private:
  std::thread thread_;
};

// What an exception says; for catch blocks.
std::string what_of_current_exception();

// body(), which answers a Status; what it throws becomes an error of that place.
Status guarded(std::string_view place, const std::function<Status()>& body);

}  // namespace onemap::daemon
