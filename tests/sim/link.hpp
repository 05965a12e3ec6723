#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/base/time.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

using test::Random;

// What a way from one robot to another does to datagrams. Shares are of datagrams, each way.
struct LinkModel {
  double loss = 0.0;         // independent of each other
  double duplication = 0.0;  // a second copy, delayed on its own
  Duration delay = std::chrono::milliseconds(5);
  Duration jitter{};      // uniform, added to the delay; reorders
  Duration delay_tail{};  // mean of an exponential addition; reorders, too
  double held_back = 0.0;
  Duration held_back_for = std::chrono::milliseconds(30);
  double flipped = 0.0;  // one bit of it, anywhere
  // Gilbert and Elliott's two states, in time: while it is bad, `burst_loss` is lost.
  Duration burst_every{}, burst_lasts{};  // means; 0: never
  double burst_loss = 1.0;
  std::uint64_t bytes_per_second = 0;   // 0: any number
  std::size_t queue_bytes = 64u << 10;  // wait for their turn; what comes then is dropped
};

// One direction of a link, with its own randomness: what happens on others does not change what happens here.
class Link {
 public:
  explicit Link(std::uint64_t seed) : random_(seed) {}

  struct Arrival {
    Instant at;
    std::optional<std::uint32_t> flipped_bit;
  };
  struct Fate {
    std::array<Arrival, 2> arrivals{};
    std::size_t copies = 0;  // that arrive: 0, 1 or 2
  };
  Fate send(const LinkModel& model, Instant now, std::size_t bytes);
  // What is sent before then waits until then.
  void clog(Instant until) { clogged_until_ = until; }

 private:
  bool bad_now(const LinkModel& model, Instant now);
  Duration exponential(Duration mean);
  Arrival arrival(const LinkModel& model, Instant departed, std::size_t bytes);
  Random random_;
  Instant free_at_{}, clogged_until_{};
  bool bad_ = false;
  Instant turns_at_{};  // from good to bad or back
};

}  // namespace onemap::comms::sim
