#include "pacer.hpp"

#include <algorithm>

#include "comms/datagram_port.hpp"

namespace onemap::comms {

Pacer::Pacer(std::uint64_t bytes_per_second, std::size_t train_datagrams)
    : rate_(std::max<std::uint64_t>(bytes_per_second, 1)),
      train_bytes_((std::max<std::size_t>(train_datagrams, 1) - 1) * kMaxDatagramBytes) {}

Duration Pacer::cost(std::uint64_t bytes) const {
  return Duration(static_cast<std::int64_t>(bytes * 1'000'000'000u / rate_));
}

void Pacer::sent(Instant now, std::size_t bytes) { next_ = std::max(next_, now - cost(train_bytes_)) + cost(bytes); }

}  // namespace onemap::comms
