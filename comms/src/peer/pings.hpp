#pragma once
#include <cstdint>
#include <optional>

#include "hal/base/time.hpp"

namespace onemap::comms {

// Questions for the round trip to one peer, one on its way at a time, and the answer to its own.
class Pings {
 public:
  static constexpr auto kGap = std::chrono::milliseconds(200);
  bool due = false;
  std::optional<std::uint32_t> answer_due;  // the token that it sent last

  std::uint32_t next_token() const { return token_ + 1; }
  void sent(Instant now) {
    ++token_;
    due = false;
    sent_ = now;
    next_ = now + kGap;
  }
  // The time since the question that this answers; nothing when it answers none.
  std::optional<Duration> answered(Instant now, std::uint32_t token) {
    if (!sent_ || token != token_) return std::nullopt;
    const Duration time = now - *sent_;
    sent_.reset();
    return time;
  }
  Instant next() const { return next_; }  // not asked again before

 private:
  std::uint32_t token_ = 0;
  std::optional<Instant> sent_;
  Instant next_{};
};

}  // namespace onemap::comms
