#pragma once
#include <cassert>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace onemap {

// Between two threads: push waits while the queue is full, pop waits while it is empty. close() wakes everybody; what
// was pushed before is still popped, then pop returns nothing. All memory is taken by the constructor.
template <class T>
class BlockingQueue {
 public:
  // capacity: at least one item.
  explicit BlockingQueue(std::size_t capacity) : ring_(capacity) { assert(capacity > 0); }

  // False, and the value is gone, when the queue is closed.
  bool push(T value) {
    std::unique_lock lock(mutex_);
    not_full_.wait(lock, [&] { return closed_ || used_ < ring_.size(); });
    if (closed_) return false;
    append(std::move(value));
    return true;
  }
  // For a producer that must not wait: the oldest item makes room, and is counted.
  bool push_dropping_oldest(T value) {
    std::optional<T> oldest;  // destroyed after the lock is given up
    std::unique_lock lock(mutex_);
    if (closed_) return false;
    if (used_ == ring_.size()) {
      oldest = take_oldest();
      ++dropped_;
    }
    append(std::move(value));
    lock.unlock();
    return true;
  }
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    not_empty_.wait(lock, [&] { return closed_ || used_ > 0; });
    return pop_locked();
  }
  std::optional<T> try_pop() {
    std::unique_lock lock(mutex_);
    return pop_locked();
  }
  void close() {
    std::unique_lock lock(mutex_);
    closed_ = true;
    not_empty_.notify_all();
    not_full_.notify_all();
  }
  std::uint64_t dropped() const {
    std::unique_lock lock(mutex_);
    return dropped_;
  }
  std::size_t capacity() const { return ring_.size(); }
  std::size_t used() const {
    std::unique_lock lock(mutex_);
    return used_;
  }

 private:
  void append(T value) {
    ring_[(oldest_ + used_) % ring_.size()] = std::move(value);
    ++used_;
    not_empty_.notify_one();
  }
  std::optional<T> take_oldest() {
    std::optional<T> value = std::exchange(ring_[oldest_], std::nullopt);
    oldest_ = (oldest_ + 1) % ring_.size();
    --used_;
    return value;
  }
  std::optional<T> pop_locked() {
    if (used_ == 0) return std::nullopt;
    not_full_.notify_one();
    return take_oldest();
  }

  mutable std::mutex mutex_;
  std::condition_variable not_full_, not_empty_;
  std::vector<std::optional<T>> ring_;
  std::size_t oldest_ = 0, used_ = 0;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace onemap
