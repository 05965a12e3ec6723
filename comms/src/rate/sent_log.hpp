#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/base/time.hpp"

namespace onemap::comms {

// When the last 2048 datagrams to one endpoint left, and how many bytes had left by then. Takes its memory with the
// first one.
class SentLog {
 public:
  static constexpr std::size_t kSize = 2048;
  struct Entry {
    std::uint32_t counter = 0;  // 0: nothing
    Instant at{};
    std::uint64_t bytes = 0;  // sent so far, this datagram included
  };
  void sent(Instant now, std::uint32_t counter, std::size_t bytes) {
    if (entries_.empty()) entries_.resize(kSize);
    bytes_ += bytes;
    entries_[counter % kSize] = {counter, now, bytes_};
  }
  const Entry* find(std::uint32_t counter) const {  // nullptr: too long ago, or never sent
    if (entries_.empty() || counter == 0) return nullptr;
    const Entry& entry = entries_[counter % kSize];
    return entry.counter == counter ? &entry : nullptr;
  }

 private:
  std::vector<Entry> entries_;
  std::uint64_t bytes_ = 0;
};

}  // namespace onemap::comms
