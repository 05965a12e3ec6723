#pragma once
// One direction of a link as a function of time: what the emulator on a TUN device does to packets, and what tests in
// virtual time do. Equal seeds and equal packets give equal answers.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/base/time.hpp"
#include "support/random.hpp"

namespace onemap::test {

struct LinkTraits {
  double bits_per_second = 20e6;  // of packets as they are on the way, IP header included
  Duration delay = std::chrono::milliseconds(5);
  Duration jitter{};           // uniform, on top; packets stay in order unless reordering says otherwise
  double loss = 0.0;           // of single packets, behind the narrow place: they took their time there
  double burst = 0.0;          // probability that a run of losses begins with a packet
  double burst_packets = 8.0;  // mean length of such a run
  double duplication = 0.0;
  double reordering = 0.0;  // probability that a packet is held back
  Duration held_back = std::chrono::milliseconds(10);
  std::size_t queue_bytes = 1u << 20;  // what waits beyond that is dropped
};

struct LinkCount {
  std::uint64_t packets = 0, bytes = 0;    // that came to the link
  std::uint64_t overflowed = 0, lost = 0;  // of them: no room in the queue; lost on the way
  std::uint64_t duplicated = 0, reordered = 0;
};

class LinkModel {
 public:
  LinkModel(const LinkTraits& traits, std::uint64_t seed) : traits_(traits), random_(seed) {}

  struct Arrivals {
    std::array<Instant, 2> at{};
    std::size_t count = 0;
  };
  // When a packet that comes to the link at `now` (never earlier than the one before) leaves it: never, once or twice.
  Arrivals pass(Instant now, std::size_t bytes) {
    ++count_.packets;
    count_.bytes += bytes;
    Arrivals arrivals;
    if (up_ && fits(now, bytes)) {
      free_ = std::max(free_, now) + time_for(bytes);
      if (keep_queues_) queues_.push_back(free_ - now);
      if (is_lost()) {
        ++count_.lost;
      } else {
        arrivals.at[arrivals.count++] = on_its_way();
        if (random_.unit() < traits_.duplication) {
          ++count_.duplicated;
          arrivals.at[arrivals.count++] = on_its_way();
        }
      }
    } else {
      ++count_.overflowed;
    }
    return arrivals;
  }
  Duration queue(Instant now) const { return std::max(free_ - now, Duration::zero()); }
  void set(const LinkTraits& traits) { traits_ = traits; }
  const LinkTraits& traits() const { return traits_; }
  void set_up(bool up) { up_ = up; }
  const LinkCount& count() const { return count_; }
  // How long each packet stood in the queue and on the sender's air, from now on.
  void keep_queues(bool keep) {
    keep_queues_ = keep;
    queues_.clear();
  }
  const std::vector<Duration>& queues() const { return queues_; }

 private:
  Duration time_for(std::size_t bytes) const {
    return Duration(static_cast<std::int64_t>(static_cast<double>(bytes) * 8e9 / traits_.bits_per_second));
  }
  bool fits(Instant now, std::size_t bytes) const {
    const double waiting = to_seconds(queue(now)) * traits_.bits_per_second / 8;
    return waiting + static_cast<double>(bytes) <= static_cast<double>(traits_.queue_bytes);
  }
  bool is_lost() {
    if (run_ > 0) return --run_, true;
    if (random_.unit() < traits_.loss) return true;
    if (random_.unit() >= traits_.burst) return false;
    for (run_ = 0; random_.unit() < 1.0 - 1.0 / traits_.burst_packets;) ++run_;
    return true;
  }
  Instant on_its_way() {
    Instant at = free_ + traits_.delay;
    if (traits_.jitter.count() > 0) at += Duration(random_.integer(0, traits_.jitter.count() - 1));
    if (random_.unit() < traits_.reordering) {
      ++count_.reordered;
      return at + traits_.held_back;
    }
    return last_ = std::max(at, last_);
  }

  LinkTraits traits_;
  Random random_;
  bool up_ = true, keep_queues_ = false;
  Instant free_{}, last_{};
  std::uint64_t run_ = 0;
  LinkCount count_;
  std::vector<Duration> queues_;
};

}  // namespace onemap::test
