#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "comms/wire/frames.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"
#include "rate/loss_meter.hpp"
#include "rate/queue_delay.hpp"
#include "rate/sent_log.hpp"

namespace onemap::comms {

// Bytes a second on the wire, IP and UDP headers included.
struct RateBounds {
  double least = 8'000, first = 125'000, most = 125'000'000;
};

// How fast data may go to one neighbour, found from its feedback alone (comms/PROTOCOL.md, Pacing): as fast as keeps
// about 15 ms of data waiting at the narrowest place of the way. Loss that does not come from sending too much does not
// slow it.
class RateController {
 public:
  static constexpr std::size_t kIpUdpBytes = 28;
  explicit RateController(const RateBounds& bounds = {}, Memory& memory = heap());

  // A datagram left, with so many bytes of UDP payload. `data`: it waited for open().
  void sent(Instant now, std::uint32_t counter, std::size_t bytes, bool data);
  // What was to be sent was sent, or something else holds it up: what arrives from now on does not say what the way
  // could carry.
  void held_up() { limited_ = true; }
  void feedback(Instant now, const wire::Feedback& feedback);

  bool open(Instant now) const { return next(now) <= now; }
  Instant next(Instant now) const;  // data may go from then on
  bool silent(Instant now) const;   // data went out and nothing is heard of it: only a probe goes now and then
  const RateBounds& bounds() const { return bounds_; }
  double bytes_per_second() const { return rate_; }
  double loss() const { return loss_.smoothed(); }
  Duration queue() const { return delay_.known() ? delay_.queue() : Duration::zero(); }
  Duration round_trip() const { return round_trip_; }  // 0: not measured

 private:
  struct Point {              // the newest datagram that a feedback speaks of
    Duration clock{};         // the peer's, at arrival
    std::uint64_t bytes = 0;  // sent by then
    std::uint32_t counter = 0;
  };
  enum class Phase { startup, steady };
  void begin_again();
  void start_over();
  void waits_no_longer(Instant now, std::uint32_t highest);
  void measure(const SentLog::Entry& sent);
  void start_up(double delivery, bool limited);
  void steer(Instant now);
  void drain(Instant now);
  bool drain_due(Instant now);

  RateBounds bounds_;
  double rate_, capacity_;
  Phase phase_ = Phase::startup;
  SentLog log_;
  QueueDelay delay_;
  LossMeter loss_;
  std::pmr::deque<Point> points_;
  bool limited_ = true;            // as held_up() said, since the last datagram
  std::uint32_t limited_at_ = 0;   // the last datagram before which it was held up
  std::uint32_t newest_data_ = 0;  // counter of the last datagram with data
  std::optional<wire::Feedback> last_;
  Instant last_at_{};  // when `last_` came
  Duration clock_{};   // the peer's, at the arrival of last_'s newest datagram, unfolded
  double best_ = 0.0;  // delivery so far, starting up
  int no_faster_ = 0;  // feedbacks without more of it
  Instant next_{};
  Instant data_at_{};
  std::optional<Instant> waits_since_;  // for feedback
  Duration round_trip_{};
  Instant breaks_at_{};
  bool broken_ = false;  // the circuit, until that loss is over
  std::optional<Instant> drained_;
  bool for_losses_ = false;  // this drain, or the next
  bool full_ = false;        // the queue was, since the last drain
};

}  // namespace onemap::comms
