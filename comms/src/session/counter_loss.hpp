#pragma once
#include <cstdint>

namespace onemap::comms {

// Which share of what a sender numbered did not come, smoothed over blocks of 64 numbers. The first block is shorter: a
// coarse figure soon is worth more than none.
class CounterLoss {
 public:
  void begin(std::uint64_t at);      // the first number that came: what was sent before we listened is not lost
  void overtaken(std::uint64_t at);  // one that others came before
  void newest(std::uint64_t at);
  double loss() const { return loss_; }

 private:
  static constexpr std::uint64_t kBlock = 64, kFirstBlock = 16;
  std::uint64_t block_start_ = 0, received_in_block_ = 0;
  double loss_ = 0.0;
  bool measured_ = false;
};

}  // namespace onemap::comms
