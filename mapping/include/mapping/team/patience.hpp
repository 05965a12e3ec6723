#pragma once
#include <map>

#include "hal/base/time.hpp"

namespace onemap::mapping {

// For how long each of some things has been waited for without a break. Used by one thread.
template <class Key>
class Patience {
 public:
  explicit Patience(Duration limit) : limit_(limit) {}

  // To be asked regularly: whether it is waited for now. True when that has been so for longer than the limit.
  bool exhausted(const Key& key, bool waiting, Instant now) {
    if (!waiting) {
      since_.erase(key);
      return false;
    }
    return now - since_.try_emplace(key, now).first->second > limit_;
  }
  void reset() { since_.clear(); }

 private:
  const Duration limit_;
  std::map<Key, Instant> since_;
};

}  // namespace onemap::mapping
