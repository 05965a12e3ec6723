#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/base/time.hpp"

namespace onemap::comms {

// Which share of the datagrams to a peer is lost. What is lost while the queue is drained is the link's own loss, and
// no reason to send less; what comes on top when more is sent is a queue that overflows.
class LossMeter {
 public:
  void count(Instant now, std::uint32_t sent, std::uint32_t arrived);
  double recent() const;                         // of the last 200 datagrams or more
  double smoothed() const { return smoothed_; }  // over some seconds
  // Loss beyond the link's own, as a share of what is taken for a sign of congestion: 1 and more is too much.
  double excess() const;
  void begin_drain() { drain_ = Tally{}; }
  bool drain_tells() const { return drain_ && drain_->sent >= kTelling; }  // enough to believe another loss at once
  void end_drain();
  bool breaks() const { return breaks_; }  // more than half was lost in the last whole second
  void begin_again() { *this = {}; }

 private:
  struct Tally {
    std::uint64_t sent = 0, arrived = 0;
    double loss() const;
  };
  static constexpr std::size_t kBlocks = 4;
  static constexpr std::uint64_t kBlock = 50, kTelling = 60;  // datagrams
  double limit(std::uint64_t datagrams) const;
  Tally last(std::size_t blocks) const;
  std::array<Tally, kBlocks> blocks_{};
  std::size_t at_ = 0;
  Tally second_;
  Instant second_began_{};
  bool breaks_ = false;
  std::optional<Tally> drain_;
  std::optional<double> own_;  // of the link itself
  double smoothed_ = 0.0;
};

}  // namespace onemap::comms
