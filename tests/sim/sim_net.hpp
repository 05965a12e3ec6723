#pragma once
// A team of real Nodes over a simulated network, in virtual time: same seed, same run, byte for byte.
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "comms/guard.hpp"
#include "comms/node.hpp"
#include "sim/disk.hpp"
#include "sim/event_queue.hpp"
#include "sim/link.hpp"
#include "sim/medium.hpp"
#include "sim/topology.hpp"
#include "support/signed_logs.hpp"

namespace onemap::comms::sim {

// At least so many robots are known, and all of them say the same map and records.
bool agrees(const Node& node, std::size_t robots, std::uint8_t flags);
RobotId numbered(std::string name, std::size_t i);

// Somebody at a place in the net who is no Node: a hostile one. It hears what is sent to it and to those whom it
// hears, and sends what it wants under any address.
class Guest {
 public:
  using Send = std::function<void(const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t>)>;
  virtual ~Guest() = default;
  virtual void hear(Instant now, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes) = 0;
  virtual Instant next() const = 0;
  virtual void speak(Instant now, const Send& send) = 0;
};

// Who looks on. All of it may stay as it is.
class Witness {
 public:
  virtual ~Witness() = default;
  virtual void sent(std::size_t /*from*/, const OutgoingDatagram&) {}
  virtual void arrives(std::size_t /*to*/, const Endpoint& /*from*/, std::span<const std::uint8_t>) {}
  virtual void applied(std::size_t /*robot*/, const Record&) {}
  virtual void appended(std::size_t /*robot*/, const Record&) {}
  virtual void moved(std::size_t /*robot*/) {}  // it has dealt with a datagram, a deadline or a record of its own
  virtual void began(std::size_t /*robot*/) {}  // a new Node
};

struct Robot {
  std::unique_ptr<NodeDisk> disk;
  std::unique_ptr<LogStore> store;
  std::unique_ptr<Pins> pins = std::make_unique<Pins>();
  std::unique_ptr<Node> node;
  std::unique_ptr<Guard> guard;  // when the config says sealed
  std::unique_ptr<Guest> guest;  // in place of all these
  NodeConfig config;
  Endpoint endpoint;
  std::vector<std::shared_ptr<const Record>> applied;
  bool on = true;
  Duration clock{};         // its clock is ahead of the net's by this
  Instant stopped_until{};  // its process does not run; datagrams wait, as many as a socket holds
  std::deque<Flight> waiting;
  Instant wakes_at = Instant::max();
  TeamKey team{{1, 2, 3}};

  void start(std::uint64_t seed);
  void end();
  // Of the guard, or of the node where there is none.
  void on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes);
  void on_timer(Instant now);
  Instant next_deadline() const;
  bool next_outgoing(OutgoingDatagram& datagram);
  Counters counters() const;
};

class SimNet {
 public:
  static constexpr std::size_t kSocketDatagrams = 200;
  SimNet(std::uint64_t seed, LinkModel model, Medium::Model medium = {});
  SimNet(const SimNet&) = delete;
  SimNet& operator=(const SimNet&) = delete;
  ~SimNet();

  static Endpoint address(std::size_t robot) {
    return Endpoint::ipv4(10, 0, static_cast<std::uint8_t>(robot >> 8), static_cast<std::uint8_t>(robot), 7000);
  }
  static Endpoint group() { return Endpoint::ipv4(239, 1, 1, 1, 7000); }

  // Robots of a graph; who is connected lists each other as peers.
  void add_team(std::size_t n, const std::vector<Edge>& edges, NodeConfig base = {});
  std::size_t add(NodeConfig config, std::size_t store_bytes = 64u << 20);
  std::size_t add(NodeConfig config, std::unique_ptr<NodeDisk> disk);
  std::size_t add(std::unique_ptr<Guest> guest);

  // A new node on the store as it is, in the same life.
  void restart_node(std::size_t i);
  // The robot starts anew at its address: nothing of its memory is left.
  void restart(std::size_t i, NodeConfig config);
  // Its process is gone, or its power; what was on the way to it is lost.
  void switch_off(std::size_t i);
  // The disk as it is now is opened in another life.
  void switch_on(std::size_t i, std::uint64_t incarnation);
  void stop(std::size_t i, Duration time);  // SIGSTOP, and SIGCONT after that time
  void jump_clock(std::size_t i, Duration ahead);

  void connect(std::size_t a, std::size_t b);  // for good
  void cut(std::size_t a, std::size_t b);
  void block(std::size_t from, std::size_t to);  // as often as it is unblocked again
  void unblock(std::size_t from, std::size_t to);
  bool reaches(std::size_t from, std::size_t to) const;
  void clog(std::size_t from, std::size_t to, Instant until) { link(from, to).clog(until); }

  Robot& operator[](std::size_t i) { return robots_[i]; }
  const Robot& operator[](std::size_t i) const { return robots_[i]; }
  Node& node(std::size_t i) { return *robots_[i].node; }
  const Node& node(std::size_t i) const { return *robots_[i].node; }
  bool runs(std::size_t i) const { return robots_[i].on && robots_[i].node != nullptr; }
  std::size_t size() const { return robots_.size(); }
  Instant now() const { return now_; }
  LinkModel& model() { return model_; }
  const Medium& medium() const { return medium_; }

  RecordId append(std::size_t i, std::uint8_t lane, std::size_t bytes, std::uint16_t kind = 1);
  // As a daemon that has something to write; nothing when its store has no room.
  std::optional<RecordId> try_append(std::size_t i, std::uint8_t lane, std::size_t bytes, std::uint16_t kind = 1,
                                     std::uint32_t replaces = kNoSequence);
  void inject(std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes);

  // Runs until `done` (looked at after every event) or for at most `limit`. True: done.
  bool run_until(const std::function<bool()>& done, Duration limit);
  void run_for(Duration time);
  bool equal() const;

  std::uint64_t bytes_carried() const { return bytes_carried_; }
  std::uint64_t datagrams_carried() const { return datagrams_carried_; }
  std::uint64_t useful_bytes() const { return useful_bytes_; }
  std::size_t largest_datagram() const { return largest_; }
  // What everything that arrives is shown to, before the node sees it.
  std::function<void(std::size_t to, const Endpoint& from, std::span<const std::uint8_t>)> tap;
  std::function<void(std::size_t robot, const Record&)> on_applied;  // what a robot does with what it was given out
  Witness* witness = nullptr;

 private:
  Link& link(std::size_t from, std::size_t to);
  Robot& place(std::size_t i);
  void start_node(std::size_t i);
  Instant clock_of(const Robot& robot) const { return now_ + robot.clock; }
  void step();
  void arrive(Flight& flight);
  void wake(std::size_t i);
  void settle(std::size_t i);  // everything that it has to say or give out, and when it wakes
  void transmit(std::size_t sender, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes);
  void carry(std::size_t sender, std::size_t to, const Endpoint& from, Instant departs,
             std::span<const std::uint8_t> bytes);
  void overhear(std::size_t sender, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes);

  std::uint64_t seed_;
  Random random_;
  LinkModel model_;
  Medium medium_;
  Instant now_{std::chrono::seconds(1)};
  std::vector<Robot> robots_;
  std::vector<std::vector<std::uint8_t>> edges_;     // [a][b]: connected
  std::vector<std::vector<std::uint16_t>> blocked_;  // [from][to]: by so many
  std::vector<std::vector<std::unique_ptr<Link>>> links_;
  std::vector<std::size_t> guests_;
  std::map<Endpoint, std::size_t> places_;
  EventQueue events_;
  std::uint64_t starts_ = 0, bytes_carried_ = 0, datagrams_carried_ = 0, useful_bytes_ = 0;
  std::size_t largest_ = 0;
};

}  // namespace onemap::comms::sim
