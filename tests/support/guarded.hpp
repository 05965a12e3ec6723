#pragma once
// One honest robot with a key, whom anybody can say anything, and what it answers.
#include <optional>
#include <vector>

#include "comms/guard.hpp"
#include "comms/memory_store.hpp"
#include "comms/wire.hpp"
#include "session/group_seal.hpp"
#include "session/sealed_wire.hpp"
#include "support/other_side.hpp"

namespace onemap::comms::sim {

inline const TeamKey kTeam{{1, 2, 3}};

struct Guarded {
  explicit Guarded(std::optional<Endpoint> group = {})
      : node(node_config(group), store), guard(guard_config(group), node, pins) {
    guard.on_timer(now);
  }
  static NodeConfig node_config(const std::optional<Endpoint>& group) {
    NodeConfig config;
    config.group = group;
    config.self = RobotId::from_name("honest");
    config.sealed = true;
    return config;
  }
  static GuardConfig guard_config(const std::optional<Endpoint>& group) {
    const NodeConfig node = node_config(group);
    GuardConfig config{node.self, node.incarnation, group, kTeam, Identity(SecretSeed{1}), {}, {}, 64};
    config.random = [random = test::Random(5)](std::span<std::uint8_t> bytes) mutable {
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    };
    return config;
  }
  std::vector<Datagram> hear(const Endpoint& from, const Datagram& bytes) {
    guard.on_datagram(now, from, bytes);
    return answers();
  }
  std::vector<Datagram> answers() {
    std::vector<Datagram> all;
    OutgoingDatagram out;
    while (guard.next_outgoing(out)) {
      all.emplace_back(out.bytes().begin(), out.bytes().end());
      sent_bytes += out.size;
    }
    return all;
  }
  void pass(Duration time) {
    now += time;
    guard.on_timer(now);
    answers();
  }
  // The other side becomes a neighbour; false: it does not.
  bool meet(OtherSide& other, const Endpoint& from) {
    const auto answer = hear(from, other.hello(now));
    if (answer.size() != 1 || answer[0].size() != sealed::kAnswerBytes) return false;
    const Datagram proof = other.proof(now, answer[0]);
    if (proof.empty()) return false;
    hear(from, proof);
    return guard.sessions() > 0;
  }
  std::uint64_t refused(Refusal reason) const { return guard.counters().of(reason); }

  Instant now{std::chrono::seconds(1)};
  MemoryStore store{1u << 20};
  Pins pins;
  Node node;
  Guard guard;
  std::size_t sent_bytes = 0;
};

inline Endpoint at(std::uint16_t port) {
  return Endpoint::ipv4(192, 168, 7, static_cast<std::uint8_t>(port / 100), port);
}

inline Datagram beacon_of(const RobotId& robot) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer;
  wire::Encoder out(buffer, {});
  out.beacon({robot, 0, 0, 1, 0});
  return {buffer.begin() + wire::kHeaderBytes, buffer.begin() + static_cast<std::ptrdiff_t>(out.size())};
}

// A group datagram with this robot's beacon, as `seal` counts.
inline Datagram group_beacon(GroupSeal& seal, OtherSide& by, const RobotId& robot) {
  OutgoingDatagram datagram;
  const Datagram frames = beacon_of(robot);
  std::ranges::copy(frames, datagram.buffer.begin() + wire::kHeaderBytes);
  datagram.size = wire::kHeaderBytes + frames.size();
  seal.seal(datagram, by.random());
  return {datagram.bytes().begin(), datagram.bytes().end()};
}

}  // namespace onemap::comms::sim
