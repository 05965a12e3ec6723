#include "sim/medium.hpp"

#include <algorithm>

namespace onemap::comms::sim {

Duration Medium::cost(std::size_t bytes) const {
  if (model_.bytes_per_second == 0) return Duration{};
  return Duration(
      static_cast<std::int64_t>((bytes + model_.overhead_bytes) * 1'000'000'000u / model_.bytes_per_second));
}

std::optional<Instant> Medium::send(Instant now, std::size_t from, std::size_t robots, std::size_t bytes,
                                    const Hears& hears) {
  if (model_.bytes_per_second == 0) return now;
  busy_until_.resize(robots);
  const Instant begin = std::max(now, busy_until_[from]);
  if (begin - now > model_.patience) return std::nullopt;
  const Instant end = begin + cost(bytes);
  busy_until_[from] = end;
  for (std::size_t to = 0; to < robots; ++to)
    if (to != from && hears(to)) busy_until_[to] = std::max(busy_until_[to], end);
  return end;
}

}  // namespace onemap::comms::sim
