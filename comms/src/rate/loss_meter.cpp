#include "rate/loss_meter.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::comms {

namespace {
constexpr double kTolerated = 0.05;  // beyond the link's own
constexpr double kDeviations = 2.5;
constexpr std::uint64_t kEnough = 20;  // datagrams, to say anything
}  // namespace

// Overtaking makes more arrive than were sent in between; the next tally has them too few.
double LossMeter::Tally::loss() const {
  if (sent == 0 || arrived >= sent) return 0.0;
  return 1.0 - static_cast<double>(arrived) / static_cast<double>(sent);
}

void LossMeter::count(Instant now, std::uint32_t sent, std::uint32_t arrived) {
  if (blocks_[at_].sent >= kBlock) {
    smoothed_ += 0.15 * (blocks_[at_].loss() - smoothed_);
    at_ = (at_ + 1) % kBlocks;
    blocks_[at_] = {};
  }
  const auto add = [&](Tally& tally) {
    tally.sent += sent;
    tally.arrived += arrived;
  };
  add(blocks_[at_]);
  if (drain_) add(*drain_);
  add(second_);
  if (now - second_began_ < std::chrono::seconds(1)) return;
  breaks_ = second_.sent >= kEnough && second_.loss() > 0.5;
  second_ = {};
  second_began_ = now;
}

LossMeter::Tally LossMeter::last(std::size_t blocks) const {
  Tally sum;
  for (std::size_t i = 0; i < blocks; ++i) {
    const Tally& block = blocks_[(at_ + kBlocks - i) % kBlocks];
    sum.sent += block.sent;
    sum.arrived += block.arrived;
  }
  return sum;
}

double LossMeter::recent() const { return last(kBlocks).loss(); }

// What chance brings is no excess.
double LossMeter::limit(std::uint64_t datagrams) const {
  const double n = static_cast<double>(datagrams);
  return kTolerated + kDeviations * std::sqrt(*own_ * (1.0 - *own_) / n + 0.25 / (n * n));
}

double LossMeter::excess() const {
  const Tally tally = last(kBlocks);
  if (!own_ || tally.sent < kEnough) return 0.0;
  return std::max(0.0, tally.loss() - *own_) / limit(tally.sent);
}

// Little is sent while it drains, so a drain moves what is known only half the way, unless it saw enough.
void LossMeter::end_drain() {
  if (drain_ && drain_->sent >= kEnough) {
    const double loss = drain_->loss();
    const bool another = !own_ || (drain_tells() && std::abs(loss - *own_) > limit(drain_->sent));
    own_ = another ? loss : *own_ + 0.5 * (loss - *own_);
  }
  drain_.reset();
}

}  // namespace onemap::comms
