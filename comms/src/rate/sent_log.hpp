#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// When the last datagrams to one endpoint left, and how many bytes had left by then: the last 64, and up to 2048 when
// so many leave within two seconds. Takes its memory with the first one.
class SentLog {
 public:
  static constexpr std::size_t kFirstSize = 64, kMostSize = 2048;
  static constexpr Duration kSpokenOf = std::chrono::seconds(2);  // somebody may still tell that it came
  struct Entry {
    std::uint32_t counter = 0;
    Instant at{};
    std::uint64_t bytes = 0;  // sent so far, this datagram included
  };
  explicit SentLog(Memory& memory = heap()) : kept_(&memory) {}

  void sent(Instant now, std::uint32_t counter, std::size_t bytes) {
    if (kept_.empty()) kept_.resize(kFirstSize);
    const Kept& before = place(kept_, counter);
    if (before.counter != 0 && now - before.at < kSpokenOf && kept_.size() < kMostSize) grow();
    bytes_ += bytes;
    place(kept_, counter) = {now, counter, static_cast<std::uint32_t>(bytes_)};
  }
  std::optional<Entry> find(std::uint32_t counter) const {  // nothing: too long ago, or never sent
    if (kept_.empty() || counter == 0) return std::nullopt;
    const Kept& kept = kept_[counter % kept_.size()];
    if (kept.counter != counter) return std::nullopt;
    return Entry{counter, kept.at, bytes_ - static_cast<std::uint32_t>(bytes_ - kept.bytes)};
  }

 private:
  struct Kept {
    Instant at{};
    std::uint32_t counter = 0;
    std::uint32_t bytes = 0;  // the low half
  };
  using All = std::pmr::vector<Kept>;
  static Kept& place(All& all, std::uint32_t counter) { return all[counter % all.size()]; }
  // Counters follow each other, so those that had a place each have one each among twice as many.
  void grow() {
    All more(2 * kept_.size(), Kept{}, kept_.get_allocator());
    for (const Kept& kept : kept_)
      if (kept.counter != 0 && kept.at >= place(more, kept.counter).at) place(more, kept.counter) = kept;
    kept_ = std::move(more);
  }
  All kept_;
  std::uint64_t bytes_ = 0;
};

}  // namespace onemap::comms
