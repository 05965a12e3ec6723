#pragma once
#include <cstddef>
#include <cstdint>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "comms/endpoint.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms::sim {

// A datagram on its way. It is signed with the address `from`, whoever sent it.
struct Flight {
  std::size_t sender = 0, to = 0;
  Endpoint from;
  std::vector<std::uint8_t> bytes;
};

// What happens next, in virtual time: arrivals before wakings of the same moment, each in the order in which they were
// planned. Flights keep their buffers, so that a long run allocates no more than a short one.
class EventQueue {
 public:
  enum class Kind : std::uint8_t { arrival, waking };
  struct Event {
    Instant at;
    Kind kind;
    std::uint64_t order;
    std::size_t which;  // a flight, or who is woken
    bool operator>(const Event& other) const {
      return std::tie(at, kind, order) > std::tie(other.at, other.kind, other.order);
    }
  };
  bool empty() const { return events_.empty(); }
  const Event& top() const { return events_.top(); }
  Event pop() {
    const Event event = events_.top();
    events_.pop();
    return event;
  }
  void wake(Instant at, std::size_t who) { events_.push({at, Kind::waking, order_++, who}); }
  Flight& launch(Instant at) {
    if (free_.empty()) {
      free_.push_back(flights_.size());
      flights_.emplace_back();
    }
    const std::size_t which = free_.back();
    free_.pop_back();
    events_.push({at, Kind::arrival, order_++, which});
    return flights_[which];
  }
  // It has arrived: its place is taken again by the next launch.
  Flight take(std::size_t which) { return std::move(flights_[which]); }
  void give_back(std::size_t which, Flight flight) {
    flights_[which] = std::move(flight);
    free_.push_back(which);
  }

 private:
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::vector<Flight> flights_;
  std::vector<std::size_t> free_;
  std::uint64_t order_ = 0;
};

}  // namespace onemap::comms::sim
