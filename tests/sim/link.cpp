#include "sim/link.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::comms::sim {

Duration Link::exponential(Duration mean) {
  return Duration(static_cast<std::int64_t>(-std::log(1.0 - random_.unit()) * static_cast<double>(mean.count())));
}

bool Link::bad_now(const LinkModel& model, Instant now) {
  if (model.burst_every.count() <= 0) return false;
  if (turns_at_ == Instant{}) turns_at_ = now + exponential(model.burst_every);
  while (turns_at_ <= now) {
    bad_ = !bad_;
    turns_at_ += exponential(bad_ ? model.burst_lasts : model.burst_every) + Duration(1);
  }
  return bad_;
}

Link::Arrival Link::arrival(const LinkModel& model, Instant departed, std::size_t bytes) {
  Arrival arrival{departed + model.delay, std::nullopt};
  if (model.jitter.count() > 0) arrival.at += Duration(random_.integer(0, model.jitter.count() - 1));
  if (model.delay_tail.count() > 0) arrival.at += exponential(model.delay_tail);
  if (model.held_back > 0 && random_.unit() < model.held_back) arrival.at += model.held_back_for;
  if (model.flipped > 0 && random_.unit() < model.flipped)
    arrival.flipped_bit = static_cast<std::uint32_t>(random_.below(8 * bytes));
  return arrival;
}

Link::Fate Link::send(const LinkModel& model, Instant now, std::size_t bytes) {
  Fate fate;
  Instant departed = std::max(now, clogged_until_);
  if (model.bytes_per_second > 0) {
    const auto cost = [&](std::size_t n) {
      return Duration(static_cast<std::int64_t>(n * 1'000'000'000u / model.bytes_per_second));
    };
    if (free_at_ > departed + cost(model.queue_bytes)) return fate;
    departed = free_at_ = std::max(free_at_, departed) + cost(bytes);
  }
  const double loss = bad_now(model, now) ? std::max(model.loss, model.burst_loss) : model.loss;
  const int copies = model.duplication > 0 && random_.unit() < model.duplication ? 2 : 1;
  for (int copy = 0; copy < copies; ++copy) {
    if (loss > 0 && random_.unit() < loss) continue;
    fate.arrivals[fate.copies++] = arrival(model, departed, bytes);
  }
  return fate;
}

}  // namespace onemap::comms::sim
