#pragma once
#include <cstddef>
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::comms {

// Spreads record bodies over time: everything that leaves uses up the rate, and only bodies wait for it. A train of
// datagrams may leave at once after a pause.
class Pacer {
 public:
  Pacer(std::uint64_t bytes_per_second, std::size_t train_datagrams);
  void sent(Instant now, std::size_t bytes);
  bool open(Instant now) const { return next_ <= now; }
  Instant next() const { return next_; }  // bodies may go from then on

 private:
  Duration cost(std::uint64_t bytes) const;
  std::uint64_t rate_, train_bytes_;
  Instant next_{};
};

}  // namespace onemap::comms
