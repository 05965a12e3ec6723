// The parts of the rate control, each by itself.
#include <gtest/gtest.h>

#include "peer/push_queue.hpp"
#include "rate/airtime.hpp"
#include "rate/arrivals.hpp"
#include "rate/lane_order.hpp"
#include "rate/loss_meter.hpp"
#include "rate/queue_delay.hpp"
#include "rate/rate_controller.hpp"
#include "rate/sent_log.hpp"

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

const Instant kStart{100s};

TEST(SentLog, KnowsTheLast2048) {
  SentLog log;
  EXPECT_FALSE(log.find(1));
  for (std::uint32_t i = 1; i <= 3000; ++i) log.sent(kStart + i * 1ms, i, 10);
  EXPECT_FALSE(log.find(0));
  EXPECT_FALSE(log.find(952));
  ASSERT_TRUE(log.find(953));
  EXPECT_EQ(log.find(953)->bytes, 9530u);
  EXPECT_EQ(log.find(3000)->at, kStart + 3s);
  EXPECT_FALSE(log.find(3001));
}

TEST(QueueDelay, IsWhatComesOnTopOfTheShortestWay) {
  QueueDelay delay;
  EXPECT_FALSE(delay.known());
  delay.sample(kStart, -7s + 12ms);
  EXPECT_EQ(delay.queue(), 0ms);
  delay.sample(kStart, -7s + 10ms);
  EXPECT_EQ(delay.queue(), 0ms);
  delay.sample(kStart, -7s + 30ms);
  EXPECT_EQ(delay.queue(), 0ms) << "one that is late by itself";
  delay.sample(kStart, -7s + 25ms);
  EXPECT_EQ(delay.queue(), 15ms);
}

// Drains the queue, which has `standing` left at its end, after it had 20 ms more.
Instant drain(QueueDelay& delay, Instant now, Duration way) {
  delay.sample(now, way + 20ms);
  delay.sample(now, way + 20ms);
  delay.begin_drain(now, 20ms);
  for (Duration queue = 15ms; !delay.drained(now); queue = std::max<Duration>(queue - 5ms, 0ms)) {
    now += 10ms;
    delay.sample(now, way + queue);
  }
  delay.end_drain(now);
  return now;
}

TEST(QueueDelay, ALongerWayIsBelievedAfterSixDrains) {
  QueueDelay delay;
  delay.sample(kStart, 10ms);
  Instant now = drain(delay, kStart, 10ms);
  EXPECT_GE(now - kStart, 50ms) << "it goes on until nothing gets shorter";
  EXPECT_LE(now - kStart, 100ms);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(delay.queue(), i == 0 ? 0ms : 30ms);
    now = drain(delay, now + 5s, 40ms);
    now = drain(delay, now, 40ms);  // so soon it is the same one
  }
  EXPECT_EQ(delay.queue(), 0ms);
  EXPECT_EQ(delay.last_empty(), now);
}

TEST(QueueDelay, ADrainEndsAfter400Milliseconds) {
  QueueDelay delay;
  delay.sample(kStart, 10s);
  delay.begin_drain(kStart, 20ms);
  Instant now = kStart;
  for (int i = 1; !delay.drained(now); ++i) delay.sample(now += 10ms, 10s - i * 1ms);
  EXPECT_EQ(now - kStart, 400ms);
}

void feed(LossMeter& meter, Instant& now, double loss, int datagrams) {
  double arrived = 0;
  for (int i = 0; i < datagrams; i += 10) {
    const double before = arrived;
    arrived += 10 * (1 - loss);
    meter.count(now += 5ms, 10, static_cast<std::uint32_t>(arrived) - static_cast<std::uint32_t>(before));
  }
}

TEST(LossMeter, TheLinksOwnLossIsNoExcess) {
  LossMeter meter;
  Instant now = kStart;
  feed(meter, now, 0.3, 300);
  EXPECT_EQ(meter.excess(), 0.0) << "nothing is known of the link yet";
  meter.begin_drain();
  feed(meter, now, 0.3, 100);
  meter.end_drain();
  feed(meter, now, 0.3, 300);
  EXPECT_LT(meter.excess(), 0.2);
  EXPECT_NEAR(meter.recent(), 0.3, 0.02);
  feed(meter, now, 0.6, 300);
  EXPECT_GT(meter.excess(), 1.0) << "a queue that overflows";
  meter.begin_drain();
  feed(meter, now, 0.6, 50);
  EXPECT_FALSE(meter.drain_tells());
  feed(meter, now, 0.6, 50);
  EXPECT_TRUE(meter.drain_tells());
  meter.end_drain();
  feed(meter, now, 0.6, 300);
  EXPECT_LT(meter.excess(), 0.2) << "it was lost in the drain, too: it is the link's own by now";
}

TEST(LossMeter, BreaksAtMoreThanHalfInASecond) {
  LossMeter meter;
  Instant now = kStart;
  feed(meter, now, 0.45, 1000);
  EXPECT_FALSE(meter.breaks());
  feed(meter, now, 0.7, 5000);
  EXPECT_TRUE(meter.breaks());
  feed(meter, now, 0.1, 5000);
  EXPECT_FALSE(meter.breaks());
}

TEST(Arrivals, AreToldOftenWhileDataFlowsAndSeldomElse) {
  Arrivals arrivals;
  arrivals.came(kStart, 5, 0, 100);
  EXPECT_EQ(arrivals.next(), Instant::max()) << "no data, no feedback";
  arrivals.came(kStart, 6, 1, 1200);
  EXPECT_TRUE(arrivals.due(kStart)) << "the first one after a pause";
  const wire::Feedback first = arrivals.report(kStart + 250us);
  EXPECT_EQ(first, (wire::Feedback{6, 2, 100'000'000, 250}));
  EXPECT_FALSE(arrivals.due(kStart + 1s));
  arrivals.came(kStart + 1ms, 7, 1, 1200);
  EXPECT_EQ(arrivals.next(), kStart + 100ms + 250us);
  arrivals.came(kStart + 2ms, 9, 1, 1200);
  EXPECT_EQ(arrivals.next(), kStart + 20ms + 250us);
  EXPECT_FALSE(arrivals.worth_saying(kStart + 5ms));
  EXPECT_TRUE(arrivals.worth_saying(kStart + 6ms));
  arrivals.came(kStart + 8ms, 8, 1, 1200);  // overtaken
  EXPECT_EQ(arrivals.next(), kStart + 20ms + 250us) << "three are a thin flow";
  arrivals.came(kStart + 8ms, 10, 1, 1200);
  EXPECT_EQ(arrivals.next(), kStart + 10ms + 250us);
  EXPECT_EQ(arrivals.report(kStart + 10ms), (wire::Feedback{10, 6, 100'008'000, 2000}));
}

TEST(Arrivals, MeasureHowFastDataComes) {
  Arrivals arrivals;
  for (std::uint64_t i = 1; i <= 1000; ++i) arrivals.came(kStart + i * 1ms, i, 1, 1000);
  EXPECT_NEAR(arrivals.bytes_per_second(), 1e6, 3e4);
}

TEST(LaneOrder, TheLowestGoesFirstAndVoxelsKeepATenth) {
  LaneOrder order;
  std::array<std::size_t, kLaneCount> bytes{};
  const auto run = [&](std::array<bool, kLaneCount> waits, int datagrams) {
    bytes = {};
    const auto waiting = [&](std::uint8_t lane) { return waits[lane]; };
    for (int i = 0; i < datagrams; ++i) {
      const std::uint8_t lane = order.next(waiting);
      if (lane == kLaneCount) return;
      order.sent(lane, 1112, waiting);
      bytes[lane] += 1112;
    }
  };
  run({false, false, false, false, false}, 1);
  EXPECT_EQ(bytes, (std::array<std::size_t, kLaneCount>{}));
  run({false, false, true, false, true}, 1000);
  EXPECT_EQ(bytes[2], 1000u * 1112) << "imagery has no floor";
  run({false, true, true, true, true}, 1000);
  EXPECT_NEAR(static_cast<double>(bytes[3]) / (1000.0 * 1112), 0.10, 0.01);
  EXPECT_NEAR(static_cast<double>(bytes[1]) / (1000.0 * 1112), 0.90, 0.01);
  run({false, false, false, true, true}, 100);
  EXPECT_EQ(bytes[3], 100u * 1112);
}

TEST(Airtime, ASlowNeighbourGetsAsMuchTimeAndNotAsManyBytes) {
  AirtimeTurn fast, slow;
  double time = 0;
  std::size_t fast_bytes = 0, slow_bytes = 0;
  for (int i = 0; i < 1100; ++i) {
    const bool turn_of_fast = fast.start(time) <= slow.start(time);
    time = turn_of_fast ? fast.sent(time, 1000, 1e6) : slow.sent(time, 1000, 1e5);
    (turn_of_fast ? fast_bytes : slow_bytes) += 1000;
  }
  EXPECT_NEAR(static_cast<double>(fast_bytes) / static_cast<double>(slow_bytes), 10.0, 0.5);
  AirtimeTurn late;  // who had nothing to send is owed nothing
  EXPECT_EQ(late.start(time), time);
}

std::shared_ptr<const PushQueue::Whole> pose(std::uint32_t seq) {
  return std::make_shared<PushQueue::Whole>(PushQueue::Whole{{{RobotId::from_name("a"), 1, 1}, seq}, 2, 9, {1, 2, 3}});
}

TEST(PushQueue, SendsAsManyCopiesAsTheLossAsksFor) {
  EXPECT_EQ(PushQueue::copies(0.0), 1u);
  EXPECT_EQ(PushQueue::copies(0.01), 2u);
  EXPECT_EQ(PushQueue::copies(0.1), 3u);
  EXPECT_EQ(PushQueue::copies(0.9), 3u);
  PushQueue queue;
  EXPECT_TRUE(queue.push(pose(0), kStart, 0.1));
  EXPECT_TRUE(queue.due(kStart));
  EXPECT_EQ(queue.front().id.seq, 0u);
  EXPECT_EQ(queue.front().total_bytes, 3u);
  queue.sent(kStart);
  EXPECT_FALSE(queue.due(kStart));
  EXPECT_EQ(queue.next(), kStart + PushQueue::kApart);
  EXPECT_TRUE(queue.push(pose(1), kStart + 1ms, 0.0));
  EXPECT_EQ(queue.front().id.seq, 1u) << "news go before copies that are due later";
  queue.sent(kStart + 1ms);
  queue.sent(kStart + 4ms);
  EXPECT_TRUE(queue.holds(pose(0)->id));
  queue.sent(kStart + 8ms);
  EXPECT_FALSE(queue.holds(pose(0)->id));
  EXPECT_EQ(queue.next(), Instant::max());
}

TEST(PushQueue, ManyAtOnceAreNoNews) {
  PushQueue queue;
  for (std::uint32_t i = 0; i < PushQueue::kMost; ++i) EXPECT_TRUE(queue.push(pose(i), kStart, 0.0));
  EXPECT_FALSE(queue.push(pose(99), kStart, 0.0));
}

// A link by hand: what is sent now comes `way` later and is told at once.
struct Told {
  RateController rate;
  Instant now = kStart;
  std::uint32_t counter = 0, received = 0;
  explicit Told(const RateBounds& bounds = {}) : rate(bounds) {}
  void send(bool data = true) { rate.sent(now, ++counter, 1172, data); }
  void tell(Duration way = 5ms) {
    ++received;
    const auto arrived = std::chrono::duration_cast<std::chrono::microseconds>((now + way).time_since_epoch());
    now += way;
    rate.feedback(now, {counter, received, static_cast<std::uint32_t>(arrived.count()), 0});
  }
};

TEST(RateController, StartsSlowlyWithATrainOfEight) {
  Told link;
  int train = 0;
  for (; link.rate.open(link.now); ++train) link.send();
  EXPECT_EQ(train, 8);
  EXPECT_EQ(link.rate.bytes_per_second(), 125'000.0);
  EXPECT_NEAR(to_seconds(link.rate.next(link.now) - link.now), 1200 / 125e3, 2e-3);
}

TEST(RateController, SilenceLeavesAProbeNowAndThen) {
  Told link;
  link.send();
  link.tell();
  EXPECT_FALSE(link.rate.silent(link.now + 10s)) << "nothing is on its way";
  link.send();
  EXPECT_FALSE(link.rate.silent(link.now + 299ms));
  EXPECT_TRUE(link.rate.silent(link.now + 311ms));
  link.now += 400ms;
  ASSERT_TRUE(link.rate.open(link.now));
  link.send();
  EXPECT_EQ(link.rate.next(link.now), link.now + 100ms);
  const double before = link.rate.bytes_per_second();
  link.now += 10ms;
  link.tell();
  EXPECT_FALSE(link.rate.silent(link.now));
  EXPECT_LE(link.rate.bytes_per_second(), before);
}

TEST(RateController, OfWhatIsNoDataNothingNeedBeHeard) {
  Told link;
  link.send();
  link.send(false);
  ++link.received;
  link.now += 5ms;
  link.rate.feedback(link.now, {1, 1, 5'000, 0});
  EXPECT_FALSE(link.rate.silent(link.now + 10s));
}

// A datagram now and then, each up to 20 ms late: that says nothing about what the way lets through.
TEST(RateController, JitterOfAThinFlowIsNoQueue) {
  Told link;
  for (int i = 0; i < 60; ++i) {
    link.rate.held_up();
    link.send();
    link.tell(5ms + (i % 3 == 0 ? 0ms : 20ms));
    link.now += 100ms;
  }
  EXPECT_GE(link.rate.bytes_per_second(), 50'000.0);
}

TEST(RateController, NonsenseAndOldNewsAreIgnored) {
  Told link;
  link.send();
  link.send();
  link.tell();
  const double rate = link.rate.bytes_per_second();
  const Duration round_trip = link.rate.round_trip();
  for (const wire::Feedback& wrong :
       {wire::Feedback{99, 9, 0, 0}, {1, 1, 0, 0}, {2, 2, 0, 0xFFFFFFFF}, {0, 0, 0, 0}, {0xFFFFFFFF, 0, 0, 0}})
    link.rate.feedback(link.now + 1s, wrong);
  EXPECT_EQ(link.rate.bytes_per_second(), rate);
  EXPECT_EQ(link.rate.round_trip(), round_trip);
}

TEST(RateController, KeepsItsBounds) {
  Told slow({.least = 5'000, .first = 125'000, .most = 50'000});
  EXPECT_EQ(slow.rate.bytes_per_second(), 50'000.0);
  for (int i = 0; i < 200; ++i) {
    slow.send();
    slow.tell(1ms);
    EXPECT_LE(slow.rate.bytes_per_second(), 50'000.0);
  }
  Told lossy({.least = 20'000, .first = 125'000, .most = 1e6});
  for (const Instant end = lossy.now + 60s; lossy.now < end; lossy.now += 1ms) {
    if (!lossy.rate.open(lossy.now)) continue;
    lossy.send();
    if (lossy.counter % 4 == 0) lossy.tell();
  }
  EXPECT_EQ(lossy.rate.bytes_per_second(), 20'000.0) << "three of four were lost: the breaker, second after second";
}

}  // namespace
}  // namespace onemap::comms
