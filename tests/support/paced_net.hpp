#pragma once
// Real Nodes, behind Guards where their config says sealed, over links with a rate and a queue, in virtual time. Two
// robots each have a link of their own, or several pairs of robots share one.
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "support/link_model.hpp"
#include "support/signed_logs.hpp"

namespace onemap::comms::paced {

inline constexpr std::size_t kIpUdpBytes = 28;

class PacedNet {
 public:
  explicit PacedNet(std::uint64_t seed) : random_(seed) {}

  struct Robot {
    std::unique_ptr<MemoryStore> store;
    std::unique_ptr<Pins> pins = std::make_unique<Pins>();
    std::unique_ptr<Node> node;
    std::unique_ptr<Guard> guard;
    std::function<void(const Record&)> applied;
    bool on = true;

    void on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes) {
      guard ? guard->on_datagram(now, from, bytes) : node->on_datagram(now, from, bytes);
    }
    void on_timer(Instant now) { guard ? guard->on_timer(now) : node->on_timer(now); }
    Instant next_deadline() const { return guard ? guard->next_deadline() : node->next_deadline(); }
    bool next_outgoing(OutgoingDatagram& datagram) {
      return guard ? guard->next_outgoing(datagram) : node->next_outgoing(datagram);
    }
  };
  static Endpoint address(std::size_t robot) {
    return Endpoint::ipv4(10, 0, 0, 1, static_cast<std::uint16_t>(7000 + robot));
  }
  std::size_t add(NodeConfig config) {
    const std::size_t i = robots_.size();
    config.self = RobotId::from_name("robot" + std::to_string(i));
    config.identity = sim::identity_of(config.self);
    Robot robot;
    robot.store = std::make_unique<MemoryStore>(256u << 20);
    robot.node = std::make_unique<Node>(config, *robot.store);
    if (config.sealed) robot.guard = guard_of(config, robot);
    robots_.push_back(std::move(robot));
    return i;
  }
  using Link = std::shared_ptr<test::LinkModel>;
  Link link(const test::LinkTraits& traits) { return std::make_shared<test::LinkModel>(traits, random_.next()); }
  // What goes from a to b takes this link; several ways may share one.
  void route(std::size_t a, std::size_t b, Link link) { ways_[{a, b}] = std::move(link); }
  test::LinkModel& way(std::size_t a, std::size_t b) { return *ways_.at({a, b}); }

  Node& node(std::size_t i) { return *robots_[i].node; }
  Robot& operator[](std::size_t i) { return robots_[i]; }
  Instant now() const { return now_; }
  std::uint64_t wire_bytes() const { return wire_bytes_; }  // UDP payload of all

  RecordId append(std::size_t i, std::uint8_t lane, std::size_t bytes) {
    std::vector<std::uint8_t> body(bytes);
    for (auto& byte : body) byte = static_cast<std::uint8_t>(random_.next() >> 56);
    const auto id = node(i).append(now_, lane, 1, std::move(body));
    drain(i);
    return id.value();
  }
  // Keeps `ahead` bytes of voxels waiting for robot `to`, in records of this size.
  void feed(std::size_t from, std::size_t to, std::size_t record_bytes, std::size_t ahead) {
    feeds_.push_back({from, to, record_bytes, ahead, {}});
  }
  // Something that happens again and again.
  void every(Duration interval, std::function<void()> what) { timers_.push_back({now_ + interval, interval, what}); }
  // What others put on a link: anything that takes part with packets of its own.
  void at(Instant when, std::function<void()> what) { events_.push({when, order_++, std::move(what)}); }

  void run_for(Duration time) {
    const Instant end = now_ + time;
    for (std::size_t i = 0; i < robots_.size(); ++i) drain(i);
    while (true) {
      refill();
      const Instant next = next_event();
      if (next > end) break;
      now_ = std::max(now_, next);
      step();
    }
    now_ = end;
  }

 private:
  struct Event {
    Instant at;
    std::uint64_t order;
    std::function<void()> what;
    bool operator>(const Event& other) const { return std::tie(at, order) > std::tie(other.at, other.order); }
  };
  struct Timer {
    Instant next;
    Duration interval;
    std::function<void()> what;
  };
  struct Feed {
    std::size_t from, to, record_bytes, ahead;
    std::deque<RecordId> written;
  };

  std::unique_ptr<Guard> guard_of(const NodeConfig& config, Robot& robot) {
    GuardConfig guard{config.self, config.incarnation, {}, TeamKey({1, 2, 3}), *config.identity, {}, {}, 64};
    guard.random = [random = test::Random(random_.next())](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    return std::make_unique<Guard>(std::move(guard), *robot.node, *robot.pins);
  }
  Instant next_event() const {
    Instant next = events_.empty() ? Instant::max() : events_.top().at;
    for (const Robot& robot : robots_)
      if (robot.on) next = std::min(next, robot.next_deadline());
    for (const Timer& timer : timers_) next = std::min(next, timer.next);
    return next;
  }
  void step() {
    while (!events_.empty() && events_.top().at <= now_) {
      const auto what = events_.top().what;
      events_.pop();
      what();
    }
    for (Timer& timer : timers_)
      if (timer.next <= now_) timer.next += timer.interval, timer.what();
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (!robots_[i].on || robots_[i].next_deadline() > now_) continue;
      robots_[i].on_timer(now_);
      drain(i);
    }
  }
  // What is there by now is forgotten, or a long test would need much memory.
  void refill() {
    for (Feed& feed : feeds_) {
      while (!feed.written.empty() && robots_[feed.to].node->hops(feed.written.front())) {
        robots_[feed.from].store->forget(feed.written.front());
        robots_[feed.to].store->forget(feed.written.front());
        feed.written.pop_front();
      }
      while (feed.written.size() * feed.record_bytes < feed.ahead)
        feed.written.push_back(append(feed.from, 3, feed.record_bytes));
    }
  }
  void drain(std::size_t i) {
    if (!robots_[i].on) return;
    OutgoingDatagram datagram;
    while (robots_[i].next_outgoing(datagram)) transmit(i, datagram);
    std::shared_ptr<const Record> record;
    while (robots_[i].node->next_applied(record))
      if (robots_[i].applied) robots_[i].applied(*record);
  }
  void transmit(std::size_t from, const OutgoingDatagram& datagram) {
    wire_bytes_ += datagram.size;
    const std::size_t to = datagram.to.port - 7000u;
    const auto way = ways_.find({from, to});
    if (way == ways_.end()) return;
    const auto arrivals = way->second->pass(now_, datagram.size + kIpUdpBytes);
    const auto bytes = datagram.bytes();
    for (std::size_t k = 0; k < arrivals.count; ++k)
      at(arrivals.at[k], [this, from, to, copy = std::vector<std::uint8_t>(bytes.begin(), bytes.end())] {
        if (!robots_[to].on) return;
        robots_[to].on_datagram(now_, address(from), copy);
        drain(to);
      });
  }

  test::Random random_;
  Instant now_{std::chrono::seconds(1)};
  std::vector<Robot> robots_;
  std::map<std::pair<std::size_t, std::size_t>, Link> ways_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::vector<Timer> timers_;
  std::vector<Feed> feeds_;
  std::uint64_t order_ = 0, wire_bytes_ = 0;
};

}  // namespace onemap::comms::paced
