#pragma once
#include <cstdint>
#include <optional>
#include <utility>

#include "comms/counters.hpp"
#include "comms/wire/header.hpp"
#include "session/receive_window.hpp"

namespace onemap::comms {

// What lies under the frames between us and one endpoint: lives are named, datagrams are counted, and plain ones are
// taken once. Sealed ones were looked at by the Guard, which says what it found.
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
  void heard_sealed(double loss) { sealed_loss_ = loss; }
  // Of unicast datagrams on the way here, 0..1.
  double loss() const { return sealed_loss_.value_or(unicast_.loss()); }
  void count_from(std::uint32_t counter) { counter_ = counter; }
  std::uint32_t counter() const { return counter_; }
  void begin_again() { unicast_ = group_ = {}; }  // another life speaks from there; we go on counting

 private:
  std::uint32_t counter_ = 1;
  ReceiveWindow unicast_, group_;
  std::optional<double> sealed_loss_;
};

}  // namespace onemap::comms
