#pragma once
#include <cstdint>
#include <utility>

#include "comms/counters.hpp"
#include "comms/wire/header.hpp"
#include "session/receive_window.hpp"

namespace onemap::comms {

// What lies under the frames between us and one endpoint, in its plain form: lives are named, datagrams are counted and
// taken once. A secure session will take this place and its header; whoever writes or reads frames sees no difference.
class Session {
 public:
  struct Arrival {
    bool unicast = true;
    std::uint64_t at = 0;  // the datagram's counter, unfolded: later ones are greater
  };
  // Its sender has heard us at the address that it answers: it repeats the number of our life.
  static bool proves(const wire::Header& header, std::uint64_t own_life) {
    return header.type == wire::DatagramType::unicast && header.receiver == own_life;
  }
  wire::Header next_header(std::uint64_t own_life, std::uint64_t their_life) {
    return {wire::DatagramType::unicast, own_life, their_life, std::exchange(counter_, wire::next_counter(counter_))};
  }
  std::uint32_t last_counter() const { return counter_ == 1 ? 0xFFFFFFFF : counter_ - 1; }  // of next_header
  // Refusal::count: the datagram is new, and `arrival` says when it was sent, among others.
  Refusal accept(const wire::Header& header, Arrival& arrival);
  double loss() const { return unicast_.loss(); }  // of unicast datagrams on the way here, 0..1
  void begin_again() { unicast_ = group_ = {}; }   // another life speaks from there; we go on counting

 private:
  std::uint32_t counter_ = 1;
  ReceiveWindow unicast_, group_;
};

}  // namespace onemap::comms
