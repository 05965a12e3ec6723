#include "session/counter_loss.hpp"

#include <algorithm>

namespace onemap::comms {

void CounterLoss::begin(std::uint64_t at) {
  block_start_ = at - 1;
  received_in_block_ = 1;
}

void CounterLoss::overtaken(std::uint64_t at) {
  if (at > block_start_) ++received_in_block_;
}

void CounterLoss::newest(std::uint64_t at) {
  ++received_in_block_;
  if (at - block_start_ < (measured_ ? kBlock : kFirstBlock)) return;
  const auto expected = static_cast<double>(at - block_start_);
  const double lost = std::max(0.0, 1.0 - static_cast<double>(received_in_block_) / expected);
  loss_ = measured_ ? 0.75 * loss_ + 0.25 * lost : lost;
  measured_ = true;
  block_start_ = at;
  received_in_block_ = 0;
}

}  // namespace onemap::comms
