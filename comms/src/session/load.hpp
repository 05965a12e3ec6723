#pragma once
#include "hal/base/time.hpp"

namespace onemap::comms {

// How many handshakes there are: beyond some a second, strangers to an address pay with a cookie; beyond more, nobody
// is served.
class Load {
 public:
  static constexpr unsigned kHeavy = 32, kMost = 256;  // a second
  static constexpr Duration kLasts = std::chrono::seconds(1);
  void came(Instant now) {
    renew(now);
    if (++hellos_ >= kHeavy) heavy_until_ = now + kLasts;
  }
  bool heavy(Instant now) const { return now < heavy_until_; }
  void be_heavy(Instant now) { heavy_until_ = now + kLasts; }
  bool may_work(Instant now) {  // the costly part of a handshake
    renew(now);
    return worked_ < kMost && ++worked_ > 0;
  }

 private:
  void renew(Instant now) {
    if (now - second_ < std::chrono::seconds(1)) return;
    second_ = now;
    hellos_ = worked_ = 0;
  }
  Instant second_{}, heavy_until_{};
  unsigned hellos_ = 0, worked_ = 0;
};

}  // namespace onemap::comms
