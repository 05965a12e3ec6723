#include "link.hpp"

namespace onemap::comms {

std::size_t Link::outstanding() const {
  std::size_t sum = 0;
  for (const AskLane& lane : lanes) sum += lane.outstanding;
  return sum;
}

void Link::forget_peer() {
  Link fresh;
  fresh.endpoint = endpoint;
  fresh.configured = configured;
  fresh.ever_heard = ever_heard;
  fresh.next_counter = next_counter;
  fresh.bytes_in = bytes_in;
  fresh.bytes_out = bytes_out;
  *this = std::move(fresh);
}

}  // namespace onemap::comms
