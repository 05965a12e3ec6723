#pragma once
// Many robots without cameras: real protocol nodes, each with a socket of its own on loopback, all on one thread. Each
// says who it is and one pose, keeps what it hears, and relays it.
#include <fmt/format.h>

#include <atomic>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/udp/udp_port.hpp"
#include "daemon/clock.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/trajectory.hpp"
#include "support/signed_logs.hpp"

namespace onemap::test {

class Crowd {
 public:
  // Robots crowd0, crowd1, ..., each at an address of its own of 127.0.1.x, who all greet the daemon at this port.
  Crowd(std::size_t count, std::uint16_t daemon_port) {
    for (std::size_t i = 0; i < count; ++i) members_.emplace_back(i, daemon_port);
  }
  ~Crowd() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

  void start() {
    thread_ = std::thread([this] { run(); });
  }
  std::vector<std::string> addresses() const {
    std::vector<std::string> all;
    for (const Member& member : members_) all.push_back(comms::to_string(member.port->local()));
    return all;
  }
  // How many robots' records the one that knows the fewest holds, its own included.
  std::size_t fewest_known() {
    const std::lock_guard lock(mutex_);
    std::size_t fewest = SIZE_MAX;
    for (const Member& member : members_) fewest = std::min(fewest, member.known());
    return fewest;
  }
  // How many of them have a living neighbour.
  std::size_t answered() {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(members_, [](const Member& m) { return m.is_answered(); }));
  }

 private:
  struct Member {
    Member(std::size_t number, std::uint16_t daemon_port) {
      const std::string name = fmt::format("crowd{}", number);
      comms::NodeConfig config;
      config.self = RobotId::from_name(name);
      config.incarnation = 1'800'000'000'000'000'000u;
      config.identity = comms::sim::identity_of(config.self);
      config.peers = {comms::Endpoint::ipv4(127, 0, 0, 1, daemon_port)};
      auto opened = comms::UdpPort::open(
          {comms::Endpoint::ipv4(127, 0, 1, static_cast<std::uint8_t>(number + 1), 0), {}, 256 << 10});
      if (!opened) throw std::runtime_error(opened.error().text());
      port = std::move(*opened);
      node = std::make_unique<comms::Node>(config, *store);
      say(0, mapping::RecordKind::hello, encode(mapping::HelloRecord{name, "none"}));
      mapping::TrajectoryRecord way;
      way.poses.emplace_back().T_robot_camera.q_wxyz = {1 << 30, 0, 0, 0};
      say(1, mapping::RecordKind::trajectory, encode(way));
    }
    void say(std::uint8_t lane, mapping::RecordKind kind, std::vector<std::uint8_t> body) {
      if (!node->append(daemon::now(), lane, static_cast<std::uint16_t>(kind), std::move(body)))
        throw std::runtime_error("a member of the crowd cannot write");
    }
    void turn(Instant now) {
      comms::IncomingDatagram in;
      while (port->receive(in)) node->on_datagram(now, in.from, in.bytes());
      if (now >= node->next_deadline()) node->on_timer(now);
      comms::OutgoingDatagram out;
      while (node->next_outgoing(out)) port->send(out);
      std::shared_ptr<const Record> record;
      while (node->next_applied(record)) {
      }
    }
    std::size_t known() const {
      std::set<RobotId> robots;
      for (const auto& [log, count] : node->frontier()) robots.insert(log.robot);
      return robots.size();
    }
    bool is_answered() const {
      return std::ranges::any_of(node->neighbours(), [](const comms::NeighbourStatus& n) { return n.alive; });
    }
    std::unique_ptr<comms::MemoryStore> store = std::make_unique<comms::MemoryStore>(8u << 20);
    std::unique_ptr<comms::UdpPort> port;
    std::unique_ptr<comms::Node> node;
  };
  void run() {
    for (; !stopping_; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
      const std::lock_guard lock(mutex_);
      for (Member& member : members_) member.turn(daemon::now());
    }
  }

  std::deque<Member> members_;
  std::mutex mutex_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace onemap::test
