#pragma once
#include <algorithm>
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::comms {

// What people allow on one link, both ways together, IP and UDP headers included. Beyond it nothing but control and
// poses is sent or asked for; those count, too. 0: no limit.
class LinkBudget {
 public:
  static constexpr auto kDay = std::chrono::hours(24);  // from the first byte, and then each next one
  LinkBudget() = default;
  LinkBudget(std::uint64_t bytes_per_second, std::uint64_t bytes_per_day)
      : per_second_(bytes_per_second), per_day_(bytes_per_day) {}

  void spent(Instant now, std::size_t bytes) {
    begin_day(now);
    today_ += bytes;
    if (per_second_ == 0) return;
    // A second's worth may be saved up.
    free_at_ = std::max(free_at_, now - std::chrono::seconds(1)) +
               Duration(static_cast<std::int64_t>(1e9 * static_cast<double>(bytes) / static_cast<double>(per_second_)));
  }
  // Whether more than control and poses may go.
  bool allows(Instant now) const { return next(now) <= now; }
  Instant next(Instant now) const {
    const bool used_up = per_day_ > 0 && today_ >= per_day_ && now < day_ends_;
    return std::max(per_second_ == 0 ? Instant{} : free_at_, used_up ? day_ends_ : Instant{});
  }
  std::uint64_t spent_today(Instant now) const { return now < day_ends_ ? today_ : 0; }

 private:
  void begin_day(Instant now) {
    if (now < day_ends_) return;
    day_ends_ = now + kDay;
    today_ = 0;
  }
  std::uint64_t per_second_ = 0, per_day_ = 0;
  std::uint64_t today_ = 0;
  Instant day_ends_{}, free_at_{};
};

}  // namespace onemap::comms
