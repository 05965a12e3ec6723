#include "rate/rate_controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace onemap::comms {

using std::chrono::microseconds;
using std::chrono::milliseconds;

namespace {
constexpr double kTarget_s = 0.015;  // of data waiting at the narrowest place
constexpr double kGain = 0.25;       // how much faster or slower than what is delivered
constexpr double kStartGain = 2.0;
constexpr double kDrainGain = 0.6;
constexpr double kSlow = 4.0;                      // times the least rate
constexpr Duration kStartQueue = milliseconds(8);  // so much waits: the way is full
constexpr double kFaster = 1.25;                   // less growth than this three times in a row: the way is full
constexpr int kNoFaster = 6;                       // feedbacks, about three round trips
constexpr Duration kDrainEvery = std::chrono::seconds(5);
constexpr Duration kSoonest = milliseconds(500);       // a drain because of losses
constexpr Duration kTogether = milliseconds(1000);     // a drain with somebody else
constexpr Duration kClockNoise = milliseconds(20);     // more queue than round trip is none
constexpr Duration kStale = std::chrono::seconds(10);  // without feedback: clocks drift, ways change
constexpr Duration kSilence = milliseconds(300), kProbe = milliseconds(100);
constexpr Duration kTrain = milliseconds(2);
constexpr double kTrainBytes = 7.0 * 1220;  // beside the first
constexpr double kShortest_s = 0.002;       // less time says nothing about a rate
constexpr std::size_t kMaxPoints = 64;

Duration seconds(double s) { return Duration(static_cast<std::int64_t>(s * 1e9)); }

// The larger share grows by the smaller part, so that those who share a way come to equal shares; in bytes a second.
double probing(double capacity) { return 31.6 * std::sqrt(capacity); }

bool later(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }
}  // namespace

RateController::RateController(const RateBounds& bounds, Memory& memory)
    : bounds_(bounds),
      rate_(std::clamp(bounds.first, bounds.least, bounds.most)),
      capacity_(rate_),
      log_(memory),
      points_(&memory) {}

void RateController::sent(Instant now, std::uint32_t counter, std::size_t payload, bool data) {
  const std::size_t bytes = payload + kIpUdpBytes;
  log_.sent(now, counter, bytes);
  if (std::exchange(limited_, false) || delay_.draining()) limited_at_ = counter;
  const double train = phase_ == Phase::startup ? kTrainBytes : std::min(to_seconds(kTrain) * rate_, kTrainBytes);
  next_ = std::max(next_, now - seconds(train / rate_)) + seconds(static_cast<double>(bytes) / rate_);
  if (!data) return;
  data_at_ = now;
  newest_data_ = counter;
  if (!waits_since_) waits_since_ = now;
}

bool RateController::silent(Instant now) const {
  return waits_since_ && now - *waits_since_ >= kSilence + 2 * round_trip_;
}

Instant RateController::next(Instant now) const { return silent(now) ? std::max(next_, data_at_ + kProbe) : next_; }

void RateController::feedback(Instant now, const wire::Feedback& feedback) {
  const auto sent = log_.find(feedback.highest);
  const Duration held = microseconds(feedback.delay_us);
  if (!sent || now - sent->at < held) return;  // of another session, or nonsense
  if (last_ && !later(feedback.highest, last_->highest)) return;
  const bool was_silent = silent(now);
  if (last_ && now - last_at_ > kStale) begin_again();
  if (was_silent) start_over();
  round_trip_ = now - sent->at - held;
  if (last_) {
    clock_ += microseconds(static_cast<std::int32_t>(feedback.clock_us - last_->clock_us));
    // What was sent into a silence says nothing about the way as it is now, and would break the circuit of the start.
    if (!was_silent) loss_.count(now, feedback.highest - last_->highest, feedback.received - last_->received);
  } else {
    clock_ = microseconds(feedback.clock_us);
  }
  delay_.sample(now, clock_ - sent->at.time_since_epoch());
  // What waits on the way there makes the way there and back longer, too. Else a clock was set.
  if (delay_.queue() > round_trip_ + kClockNoise) {
    delay_.begin_again();
    delay_.sample(now, clock_ - sent->at.time_since_epoch());
    points_.clear();
  }
  last_ = feedback;
  last_at_ = now;
  waits_no_longer(now, feedback.highest);
  measure(*sent);
  steer(now);
}

// Nothing that was measured holds any longer but how fast it went.
void RateController::begin_again() {
  delay_.begin_again();
  loss_.begin_again();
  points_.clear();
  last_.reset();
  start_over();
}

void RateController::start_over() {
  phase_ = Phase::startup;
  capacity_ = std::max(bounds_.least, capacity_ / 2);
  best_ = 0.0;
  no_faster_ = 0;
}

// Of what is no data nothing need be heard.
void RateController::waits_no_longer(Instant now, std::uint32_t highest) {
  if (waits_since_ && later(newest_data_, highest))
    waits_since_ = now;
  else
    waits_since_.reset();
}

// How fast the narrowest place let through what was sent: it is spread over the time in which it arrived. What was lost
// behind that place took its time there, too.
void RateController::measure(const SentLog::Entry& sent) {
  points_.push_back({clock_, sent.bytes, sent.counter});
  if (points_.size() > kMaxPoints) points_.pop_front();
  const Duration window =
      phase_ == Phase::startup ? milliseconds(5) : std::max<Duration>(milliseconds(40), round_trip_);
  while (points_.size() > 2 && clock_ - points_[1].clock >= window) points_.pop_front();
  const Point& since = points_.front();
  const double time = to_seconds(clock_ - since.clock);
  if (time < kShortest_s) return;
  const auto bytes = static_cast<double>(sent.bytes - since.bytes);
  const bool held_up = later(limited_at_, since.counter);
  const double queue = to_seconds(delay_.queue());
  double delivery = bytes / time;
  const bool limited = held_up && queue < kTarget_s / 2;
  // What waits when little was sent is jitter, or somebody else's: a way that lets through more than this would not be
  // filled for so long by these bytes, and that it lets through less they do not show.
  if (held_up && !limited && (bytes < kTrainBytes || phase_ == Phase::startup))
    delivery = std::max(delivery, std::min(bytes / queue, capacity_));
  if (phase_ == Phase::startup) return start_up(delivery, limited);
  if (limited && delivery < capacity_) return;
  capacity_ += 0.3 * (std::min(delivery, kStartGain * capacity_) - capacity_);
}

// Twice as fast each round trip, until the way is full.
void RateController::start_up(double delivery, bool limited) {
  if (delivery > kFaster * best_)
    no_faster_ = 0;
  else if (!limited)
    ++no_faster_;
  best_ = std::max(best_, delivery);
  capacity_ = std::max(capacity_, std::min(best_, kStartGain * capacity_));
  // Jitter looks like a queue, too, and who begins at the least rate must not stop there for it.
  const Duration full = capacity_ > kSlow * bounds_.least ? kStartQueue : 4 * kStartQueue;
  if (delay_.queue() < full && no_faster_ < kNoFaster) return;
  capacity_ = delivery;
  phase_ = Phase::steady;
}

void RateController::steer(Instant now) {
  if (loss_.breaks() && now - breaks_at_ >= std::chrono::seconds(1)) {
    breaks_at_ = now;
    capacity_ /= 2;
    phase_ = Phase::steady;
    broken_ = true;
  }
  if (broken_ &&
      !loss_.breaks()) {  // what it went down for is over, and by small steps it would take long to come back
    broken_ = false;
    phase_ = Phase::startup;
    best_ = 0.0;
    no_faster_ = 0;
  }
  capacity_ = std::clamp(capacity_, bounds_.least, bounds_.most);
  double rate = kStartGain * capacity_;
  if (phase_ == Phase::steady) {
    drain(now);
    // What little goes through a way by now is long in telling that its losses are over, and did not cause them.
    const double excess = capacity_ > kSlow * bounds_.least ? loss_.excess() : 0.0;
    const double lack = std::min(1.0 - to_seconds(delay_.queue()) / kTarget_s, 1.0 - excess);
    rate = capacity_ * (1.0 + kGain * std::clamp(lack, -1.0, 1.0)) + probing(capacity_);
    rate = std::min(rate, (1.0 + kGain) * capacity_);
    if (delay_.draining()) rate = kDrainGain * capacity_;
    if (loss_.breaks()) rate = std::min(rate, capacity_);
  }
  rate_ = std::clamp(rate, bounds_.least, bounds_.most);
}

// From time to time; soon when more is lost than before, to see whether that is the link's own; and when somebody else
// seems to drain, because only together we see the way empty.
bool RateController::drain_due(Instant now) {
  if (!drained_) return true;
  const double queue = to_seconds(delay_.queue());
  const bool fell = full_ && queue < 0.5 * kTarget_s;
  if (queue > 0.8 * kTarget_s) full_ = true;
  if (queue < 0.5 * kTarget_s) full_ = false;
  for_losses_ = loss_.excess() > 1.0 && now - *drained_ > kSoonest;
  const Instant last = std::max(*drained_, delay_.last_empty());
  return for_losses_ || now - last > kDrainEvery || (fell && now - last > kTogether);
}

void RateController::drain(Instant now) {
  if (!delay_.draining()) {
    if (!drain_due(now)) return;
    delay_.begin_drain(now, round_trip_);
    loss_.begin_drain();
    return;
  }
  if (!delay_.drained(now) || (for_losses_ && !loss_.drain_tells() && !delay_.drains_too_long(now))) return;
  delay_.end_drain(now);
  loss_.end_drain();
  drained_ = now;
  for_losses_ = full_ = false;
}

}  // namespace onemap::comms
