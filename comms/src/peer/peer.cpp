#include "peer/peer.hpp"

#include <utility>

namespace onemap::comms {

void Peer::become(const RobotId& robot, std::uint64_t incarnation, Memory& memory) {
  Peer fresh(memory);
  fresh.endpoint = endpoint;
  fresh.configured = configured;
  fresh.ever_heard = ever_heard;
  fresh.session = session;
  fresh.session.begin_again();
  fresh.rate = RateController(rate.bounds(), memory);
  fresh.budget = budget;
  fresh.traffic = traffic;
  fresh.bytes_in = bytes_in;
  fresh.bytes_out = bytes_out;
  fresh.who.robot = robot;  // before *this changes: it may be the candidate's
  fresh.who.incarnation = incarnation;
  *this = std::move(fresh);
}

}  // namespace onemap::comms
