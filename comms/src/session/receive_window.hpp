#pragma once
#include <bitset>
#include <cstdint>
#include <optional>

#include "session/counter_loss.hpp"

namespace onemap::comms {

// Which datagram counters of a sender were seen, and how many were lost. Counters have 32 bits on the wire and go
// round; here they are unfolded to 64 (serial number arithmetic, RFC 1982). A counter far from all others moves the
// window only when a second one near it follows (as in RFC 3550, appendix A.1): one forged datagram never shuts the
// true ones out.
class ReceiveWindow {
 public:
  static constexpr std::uint64_t kWindow = 2048;
  enum class Verdict { fresh, duplicate, too_old, jump };
  struct Arrival {
    Verdict verdict;
    std::uint64_t at;  // the counter unfolded: it ascends as long as the sender counts
  };
  Arrival accept(std::uint32_t counter);
  double loss() const { return meter_.loss(); }

 private:
  static constexpr std::uint64_t kNear = 64;
  void anchor(std::uint64_t at);
  void advance(std::uint64_t at);
  std::bitset<kWindow> seen_;
  std::uint64_t highest_ = 0;  // 0: nothing was seen yet
  CounterLoss meter_;
  std::optional<std::uint64_t> elsewhere_;  // the last one that was far from all others
};

}  // namespace onemap::comms
