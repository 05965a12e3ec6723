#pragma once
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

namespace onemap::daemon {

// News from one thread for another: at most `most` wait, then the oldest makes room, counted. Giving does not allocate
// beyond what T's assignment does. ring() is called, on the giver's thread, when something is there after nothing was.
template <class T>
class Feed {
 public:
  Feed(std::size_t most, std::function<void()> ring) : ring_(std::move(ring)), slots_(most) {}

  void give(T item) {
    bool first = false;
    {
      const std::lock_guard lock(mutex_);
      first = count_ == 0;
      slots_[(begin_ + count_) % slots_.size()] = std::move(item);
      if (count_ < slots_.size()) {
        ++count_;
      } else {
        begin_ = (begin_ + 1) % slots_.size();
        ++dropped_;
      }
    }
    if (first) ring_();
  }
  std::vector<T> take() {  // oldest first
    std::vector<T> items;
    const std::lock_guard lock(mutex_);
    items.reserve(count_);
    for (; count_ > 0; --count_) {
      items.push_back(std::move(slots_[begin_]));
      begin_ = (begin_ + 1) % slots_.size();
    }
    return items;
  }
  std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  const std::function<void()> ring_;
  mutable std::mutex mutex_;
  std::vector<T> slots_;  // a ring
  std::size_t begin_ = 0, count_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace onemap::daemon
