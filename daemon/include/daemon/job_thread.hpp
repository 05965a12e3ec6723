#pragma once
#include <atomic>
#include <functional>
#include <string>

#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"

namespace onemap::daemon {

// What takes long and is asked for seldom, one after another on a thread of its own. A few may wait; more are refused.
// A job that throws is its own affair: it must answer for itself.
class JobThread {
 public:
  static constexpr std::size_t kWaiting = 8;
  using Job = std::function<void(const std::atomic<bool>& stopping)>;

  explicit JobThread(std::string name);
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  bool post(Job job);  // one thread, without waiting; false: too many wait
  void stop();         // after the one that is being done; those that wait are left out

 private:
  std::atomic<bool> stopping_ = false;
  Failures failures_;
  BlockingQueue<Job> jobs_{kWaiting};
  Worker thread_;
};

}  // namespace onemap::daemon
