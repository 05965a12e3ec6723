#include "daemon/between_turns.hpp"

#include <chrono>
#include <utility>

namespace onemap::daemon {

namespace {
constexpr auto kLookForAsker = std::chrono::milliseconds(50);
}

bool BetweenTurns::run(const Job& job, const std::atomic<bool>& stop) {
  Asked asked{&job};
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    waiting_.push_back(&asked);
  }
  wake_();
  std::unique_lock lock(mutex_);
  wait(lock, asked, stop);
  if (!asked.begun) std::erase(waiting_, &asked);
  if (asked.thrown) std::rethrow_exception(asked.thrown);
  return asked.done;
}

// What has begun is waited for: it uses what is the asker's.
void BetweenTurns::wait(std::unique_lock<std::mutex>& lock, Asked& asked, const std::atomic<bool>& stop) {
  while (!asked.done && (asked.begun || (!stop && !closed_))) changed_.wait_for(lock, kLookForAsker);
}

void BetweenTurns::do_all() {
  std::unique_lock lock(mutex_);
  if (waiting_.empty()) return;
  const std::vector<Asked*> now = std::exchange(waiting_, {});
  for (Asked* asked : now) asked->begun = true;
  lock.unlock();
  for (Asked* asked : now) {
    try {
      (*asked->job)();
    } catch (...) {
      asked->thrown = std::current_exception();
    }
  }
  lock.lock();
  for (Asked* asked : now) asked->done = true;
  changed_.notify_all();
}

void BetweenTurns::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace onemap::daemon
