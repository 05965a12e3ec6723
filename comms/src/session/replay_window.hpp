#pragma once
#include <bitset>
#include <cstdint>

#include "session/counter_loss.hpp"

namespace onemap::comms {

// Which counters of a session were seen (RFC 6479, with 8192 places). Only what was authentic is shown to it, so no
// counter is too far ahead.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kWindow = 8192;
  enum class Verdict { fresh, duplicate, too_old };
  Verdict accept(std::uint64_t counter);
  std::uint64_t highest() const { return highest_; }  // when anything was seen
  double loss() const { return meter_.loss(); }

 private:
  std::bitset<kWindow> seen_;
  std::uint64_t highest_ = 0;
  bool any_ = false;
  CounterLoss meter_;
};

}  // namespace onemap::comms
