#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "hal/base/time.hpp"

namespace onemap::comms {

// How long datagrams wait in queues on the way to a peer, from samples of (the peer's clock at arrival - our clock at
// sending). The clocks differ by anything; the least sample says what an empty way takes. Because the queue is kept
// filled a little, that is only seen when the sender drains it on purpose, from time to time.
class QueueDelay {
 public:
  static constexpr std::size_t kDrains = 6;
  static constexpr Duration kOneDrain = std::chrono::seconds(4);  // those within it count as one
  void sample(Instant now, Duration clock_difference);
  // The shorter of the last two: one that was late for another reason does not count.
  Duration queue() const;
  bool known() const { return samples_ > 0; }
  // The way was seen empty, or a drain ended, then.
  Instant last_empty() const { return empty_; }

  // What is sent from now on is heard of after a round trip, queue included; before that nothing gets shorter.
  void begin_drain(Instant now, Duration round_trip);
  bool draining() const { return drain_.has_value(); }
  // The queue does not become shorter any more, or it takes too long.
  bool drained(Instant now) const;
  bool drains_too_long(Instant now) const;
  void end_drain(Instant now);
  void begin_again() { *this = {}; }  // another way, or nothing was sent for so long that the clocks may have drifted

 private:
  struct Drain {
    Instant began{}, shows{}, lowest_at{};
    Duration lowest{};
    int no_shorter = 0;  // samples since then
  };
  Duration base_{}, last_{}, before_{};
  std::uint64_t samples_ = 0, drains_ = 0;
  Instant counted_{};                       // when the last drain that counts by itself ended
  std::array<Duration, kDrains> lowest_{};  // of the last drains
  std::optional<Drain> drain_;
  Instant empty_{};
};

}  // namespace onemap::comms
