#pragma once
#include <array>
#include <cstdint>

#include "hal/base/ids.hpp"
#include "hal/base/splitmix.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

// Who greets from the address of a living neighbour under another name or life: first it has to name our life, then to
// repeat a token that was sent to that address.
struct Candidate {
  RobotId robot;
  std::uint64_t incarnation = 0;  // 0: nobody
  std::uint32_t token = 0;        // 0: it has not named us yet
  bool beacon_due = false, ping_due = false;
  Instant stays_until{};  // before that, no other takes its place
};

// Those of one address. One alone would let a life that is over, and of which datagrams still come, keep out the next.
class Candidates {
 public:
  static constexpr std::size_t kMost = 4;
  static constexpr auto kNamedStays = std::chrono::seconds(2);

  // One greeted, and named our life or not. The token is drawn when it is first needed. When all places are kept for
  // those who named us, it is not heard.
  void greeted(Instant now, const RobotId& robot, std::uint64_t life, bool names_us, SplitMix& random);
  const Candidate* proved(std::uint64_t life, std::uint32_t token) const;  // who repeats its token, or nobody
  bool due() const;
  Candidate* next();  // who is due, or nobody

 private:
  Candidate* place_of(Instant now, const RobotId& robot, std::uint64_t life);
  std::array<Candidate, kMost> places_{};
  std::size_t turn_ = 0;  // of who has not named us, the next one to go
};

}  // namespace onemap::comms
