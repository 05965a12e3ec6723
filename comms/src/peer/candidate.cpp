#include "peer/candidate.hpp"

namespace onemap::comms {

void Candidate::greeted(Instant now, const RobotId& who, std::uint64_t life, bool names_us, SplitMix& random) {
  if (robot != who || incarnation != life) {
    if (stays_until_ > now) return;
    *this = {};
    robot = who;
    incarnation = life;
  }
  if (!names_us) {
    beacon_due = true;
    return;
  }
  ping_due = true;
  if (token_ != 0) return;
  token_ = static_cast<std::uint32_t>(random.next() >> 32) | 1u;
  stays_until_ = now + kNamedStays;  // and no longer: who is there has answered by then
}

}  // namespace onemap::comms
