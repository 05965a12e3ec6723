#pragma once
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

namespace onemap::daemon {

// What other threads want done by a thread that must not wait for them: between two of its turns, while they wait.
class BetweenTurns {
 public:
  using Job = std::function<void()>;
  // wake: makes that thread begin its next turn soon.
  explicit BetweenTurns(std::function<void()> wake) : wake_(std::move(wake)) {}

  // Any other thread. What the job throws is thrown here. False: it was not done and never will be; `stop` was set
  // before its turn, or close() was called.
  bool run(const Job& job, const std::atomic<bool>& stop);
  void do_all();  // that thread, each turn
  void close();   // when that thread has ended

 private:
  struct Asked {
    const Job* job;
    bool begun = false, done = false;
    std::exception_ptr thrown{};
  };
  void wait(std::unique_lock<std::mutex>& lock, Asked& asked, const std::atomic<bool>& stop);

  const std::function<void()> wake_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Asked*> waiting_;  // of those who wait in run()
  bool closed_ = false;
};

}  // namespace onemap::daemon
