#pragma once
// A team of real Nodes over a simulated network, in virtual time: same seed, same run, byte for byte.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "support/random.hpp"

namespace onemap::comms::sim {

using test::Random;

// At least so many robots are known, and all of them say the same map and records.
inline bool agrees(const Node& node, std::size_t robots, std::uint8_t flags) {
  return node.team().size() >= robots && node.team_agrees(flags, {});
}

inline RobotId numbered(std::string name, std::size_t i) {
  name += std::to_string(i);
  return RobotId::from_name(name);
}

using Edge = std::pair<std::size_t, std::size_t>;
inline std::vector<Edge> line(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i + 1 < n; ++i) edges.emplace_back(i, i + 1);
  return edges;
}
inline std::vector<Edge> ring(std::size_t n) {
  auto edges = line(n);
  if (n > 2) edges.emplace_back(0, n - 1);
  return edges;
}
inline std::vector<Edge> star(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 1; i < n; ++i) edges.emplace_back(0, i);
  return edges;
}
inline std::vector<Edge> complete(std::size_t n) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) edges.emplace_back(i, j);
  return edges;
}

struct LinkModel {
  double loss = 0.0;         // of each datagram, each way
  double duplication = 0.0;  // a second copy, delayed on its own
  Duration delay = std::chrono::milliseconds(5);
  Duration jitter{};  // uniform, added to the delay; reorders
};

struct Robot {
  std::unique_ptr<MemoryStore> store;
  std::unique_ptr<Pins> pins = std::make_unique<Pins>();
  std::unique_ptr<Node> node;
  std::unique_ptr<Guard> guard;  // when the config says sealed
  NodeConfig config;
  Endpoint endpoint;
  std::vector<std::shared_ptr<const Record>> applied;
  bool on = true;
  TeamKey team{{1, 2, 3}};

  void start(std::uint64_t seed) {
    guard.reset();
    node = std::make_unique<Node>(config, *store);
    if (!config.sealed) return;
    const SecretSeed identity{config.self.bytes[0], config.self.bytes[5], config.self.bytes[6], 1};
    GuardConfig g{config.self, config.incarnation, config.group, team, Identity(identity), {}, {}, 64};
    g.random = [random = Random(seed)](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    guard = std::make_unique<Guard>(std::move(g), *node, *pins);
  }
  void on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes) {
    guard ? guard->on_datagram(now, from, bytes) : node->on_datagram(now, from, bytes);
  }
  void on_timer(Instant now) { guard ? guard->on_timer(now) : node->on_timer(now); }
  Instant next_deadline() const { return guard ? guard->next_deadline() : node->next_deadline(); }
  bool next_outgoing(OutgoingDatagram& datagram) {
    return guard ? guard->next_outgoing(datagram) : node->next_outgoing(datagram);
  }
  Counters counters() const { return guard ? guard->counters() : node->counters(); }
};

class SimNet {
 public:
  SimNet(std::uint64_t seed, LinkModel model) : random_(seed), model_(model) {}

  static Endpoint address(std::size_t robot) {
    return Endpoint::ipv4(127, 0, 0, 1, static_cast<std::uint16_t>(7000 + robot));
  }

  // Robots of a graph; who is connected lists each other as peers.
  void add_team(std::size_t n, const std::vector<Edge>& edges, NodeConfig base = {}) {
    for (std::size_t i = 0; i < n; ++i) {
      base.peers.clear();
      for (const auto& [a, b] : edges) {
        if (a == i) base.peers.push_back(address(b));
        if (b == i) base.peers.push_back(address(a));
      }
      add(base);
    }
    for (const Edge& edge : edges) connect(edge.first, edge.second);
  }
  std::size_t add(NodeConfig config, std::size_t store_bytes = 64u << 20) {
    const std::size_t i = robots_.size();
    if (config.self == RobotId{}) config.self = numbered("robot", i);
    robots_.push_back({});
    Robot& robot = robots_.back();
    robot.endpoint = address(i);
    robot.store = std::make_unique<MemoryStore>(store_bytes);
    robot.config = config;
    start(i);
    return i;
  }
  // A new node on the store as it is, in the same life.
  void restart_node(std::size_t i) {
    start(i);
    drain(i);
  }
  void connect(std::size_t a, std::size_t b) { edges_.insert(std::minmax(a, b)); }
  void cut(std::size_t a, std::size_t b) { edges_.erase(std::minmax(a, b)); }
  // The robot starts anew at its address: nothing of its memory is left.
  void restart(std::size_t i, NodeConfig config) {
    Robot& robot = robots_[i];
    robot.node.reset();
    robot.applied.clear();
    robot.store = std::make_unique<MemoryStore>(64u << 20);
    if (config.self == RobotId{}) config.self = numbered("robot", i);
    robot.config = config;
    start(i);
  }
  void start(std::size_t i) { robots_[i].start(1000 * ++starts_ + i); }

  Robot& operator[](std::size_t i) { return robots_[i]; }
  Node& node(std::size_t i) { return *robots_[i].node; }
  std::size_t size() const { return robots_.size(); }
  Instant now() const { return now_; }
  LinkModel& model() { return model_; }

  RecordId append(std::size_t i, std::uint8_t lane, std::size_t bytes, std::uint16_t kind = 1) {
    std::vector<std::uint8_t> body(bytes);
    for (auto& byte : body) byte = static_cast<std::uint8_t>(random_.next() >> 56);
    useful_bytes_ += bytes;
    const auto id = node(i).append(now_, lane, kind, std::move(body));
    drain(i);
    return id.value();
  }

  // Runs until `done` (looked at after every event) or for at most `limit`. True: done.
  bool run_until(const std::function<bool()>& done, Duration limit) {
    const Instant end = now_ + limit;
    for (std::size_t i = 0; i < robots_.size(); ++i) drain(i);
    while (!done()) {
      const Instant next = next_event();
      if (next > end) return now_ = end, done();
      now_ = std::max(now_, next);
      step();
    }
    return true;
  }
  void run_for(Duration time) {
    run_until([] { return false; }, time);
  }
  bool equal() const {
    for (const Robot& robot : robots_)
      if (robot.on && robot.node->frontier() != first_on().node->frontier()) return false;
    return true;
  }

  std::uint64_t bytes_carried() const { return bytes_carried_; }
  std::uint64_t useful_bytes() const { return useful_bytes_; }
  std::size_t largest_datagram() const { return largest_; }
  // What everything that arrives is shown to, before the node sees it.
  std::function<void(std::size_t to, const Endpoint& from, std::span<const std::uint8_t>)> tap;

  void inject(std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes) {
    robots_[to].on_datagram(now_, from, bytes);
    drain(to);
  }

 private:
  struct Flight {
    Instant at;
    std::uint64_t order;
    std::size_t from, to;
    std::vector<std::uint8_t> bytes;
    bool operator>(const Flight& other) const { return std::tie(at, order) > std::tie(other.at, other.order); }
  };

  const Robot& first_on() const {
    return *std::find_if(robots_.begin(), robots_.end(), [](const Robot& r) { return r.on; });
  }
  Instant next_event() const {
    Instant next = air_.empty() ? Instant::max() : air_.top().at;
    for (const Robot& robot : robots_)
      if (robot.on) next = std::min(next, std::max(now_, robot.next_deadline()));
    return next;
  }
  void step() {
    while (!air_.empty() && air_.top().at <= now_) {
      const Flight flight = air_.top();
      air_.pop();
      if (!robots_[flight.to].on || !edges_.contains(std::minmax(flight.from, flight.to))) continue;
      if (tap) tap(flight.to, robots_[flight.from].endpoint, flight.bytes);
      robots_[flight.to].on_datagram(now_, robots_[flight.from].endpoint, flight.bytes);
      drain(flight.to);
    }
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (!robots_[i].on || robots_[i].next_deadline() > now_) continue;
      robots_[i].on_timer(now_);
      drain(i);
    }
  }
  void drain(std::size_t i) {
    if (!robots_[i].on) return;
    OutgoingDatagram datagram;
    while (robots_[i].next_outgoing(datagram)) transmit(i, datagram);
    std::shared_ptr<const Record> record;
    while (robots_[i].node->next_applied(record)) robots_[i].applied.push_back(record);
  }
  void transmit(std::size_t from, const OutgoingDatagram& datagram) {
    bytes_carried_ += datagram.size;
    largest_ = std::max(largest_, datagram.size);
    for (std::size_t to = 0; to < robots_.size(); ++to) {
      if (robots_[to].endpoint != datagram.to) continue;
      const int copies = random_.unit() < model_.duplication ? 2 : 1;
      for (int copy = 0; copy < copies; ++copy) {
        if (random_.unit() < model_.loss) continue;
        Duration delay = model_.delay;
        if (model_.jitter.count() > 0) delay += Duration(random_.integer(0, model_.jitter.count() - 1));
        const auto bytes = datagram.bytes();
        air_.push({now_ + delay, order_++, from, to, {bytes.begin(), bytes.end()}});
      }
    }
  }

  Random random_;
  LinkModel model_;
  Instant now_{std::chrono::seconds(1)};
  std::vector<Robot> robots_;
  std::set<Edge> edges_;
  std::priority_queue<Flight, std::vector<Flight>, std::greater<>> air_;
  std::uint64_t order_ = 0, bytes_carried_ = 0, useful_bytes_ = 0, starts_ = 0;
  std::size_t largest_ = 0;
};

}  // namespace onemap::comms::sim
