#include "rate/arrivals.hpp"

#include <algorithm>

namespace onemap::comms {

using std::chrono::milliseconds;

namespace {
// A flow (of so many since the last report), a thin one, and a datagram now and then.
constexpr Duration kOften = milliseconds(10), kThin = milliseconds(20), kSeldom = milliseconds(100);
constexpr std::uint32_t kFlow = 4;
constexpr Duration kBlock = milliseconds(50), kPause = milliseconds(500);
}  // namespace

void Arrivals::came(Instant now, std::uint64_t counter, std::uint32_t data_frames, std::size_t bytes) {
  ++received_;
  if (counter > highest_) {
    highest_ = counter;
    highest_at_ = now;
  }
  if (data_frames == 0) return;
  measure(now, bytes);
  if (unsaid_ == 0) due_ = std::max(now, said_ + kSeldom);
  if (++unsaid_ > 1) due_ = std::min(due_, std::max(now, said_ + (unsaid_ < kFlow ? kThin : kOften)));
}

bool Arrivals::worth_saying(Instant now) const { return unsaid_ > 0 && now - said_ >= kOften / 2; }

wire::Feedback Arrivals::report(Instant now) {
  using std::chrono::duration_cast;
  using std::chrono::microseconds;
  unsaid_ = 0;
  said_ = now;
  wire::Feedback feedback;
  feedback.highest = static_cast<std::uint32_t>(highest_);
  feedback.received = received_;
  feedback.clock_us = static_cast<std::uint32_t>(duration_cast<microseconds>(highest_at_.time_since_epoch()).count());
  feedback.delay_us = static_cast<std::uint32_t>(
      std::min<std::int64_t>(duration_cast<microseconds>(now - highest_at_).count(), 0xFFFFFFFF));
  return feedback;
}

void Arrivals::measure(Instant now, std::size_t bytes) {
  if (now - measured_ > kPause) {
    measured_ = now;
    bytes_ = 0;
    return;
  }
  bytes_ += bytes;
  if (now - measured_ < kBlock) return;
  const double rate = static_cast<double>(bytes_) / to_seconds(now - measured_);
  rate_ += 0.5 * (rate - rate_);
  measured_ = now;
  bytes_ = 0;
}

}  // namespace onemap::comms
