#pragma once
#include <cstdint>

#include "hal/base/ids.hpp"
#include "hal/base/splitmix.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

// Who greets from the address of a living neighbour under another name or life: first it has to name our life, then to
// repeat a token that was sent to that address.
class Candidate {
 public:
  static constexpr auto kNamedStays = std::chrono::seconds(2);  // before that, no other takes its place
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: nobody
  bool beacon_due = false, ping_due = false;

  // It greeted, and named our life or not. The token is drawn when it is first needed.
  void greeted(Instant now, const RobotId& who, std::uint64_t life, bool names_us, SplitMix& random);
  bool proves(std::uint64_t life, std::uint32_t token) const {
    return incarnation != 0 && incarnation == life && token_ != 0 && token_ == token;
  }
  std::uint32_t token() const { return token_; }

 private:
  std::uint32_t token_ = 0;  // 0: it has not named us yet
  Instant stays_until_{};
};

}  // namespace onemap::comms
