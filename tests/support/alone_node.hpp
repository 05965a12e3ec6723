#pragma once
// A Node alone, fed by hand with whatever a test wants it to hear.
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "comms/memory_store.hpp"
#include "comms/node.hpp"
#include "comms/wire.hpp"
#include "sim_net.hpp"

namespace onemap::comms::sim {

inline const Endpoint kStranger = Endpoint::ipv4(127, 0, 0, 1, 9999);

template <class Write>
std::vector<std::uint8_t> datagram(const wire::Header& header, Write write) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  wire::Encoder out(buffer, header);
  write(out);
  return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(out.size())};
}
inline std::vector<std::uint8_t> greeting(const std::string& robot, std::uint64_t incarnation, std::uint64_t receiver,
                                          std::uint32_t counter) {
  return datagram({wire::DatagramType::unicast, incarnation, receiver, counter}, [&](wire::Encoder& out) {
    out.beacon({RobotId::from_name(robot), 0, 0, 1, 0});
  });
}

// Robot "self" in its life 77.
struct Alone {
  static constexpr std::uint64_t kLife = 77;
  MemoryStore store;
  Node node;
  Instant now{std::chrono::seconds(1)};
  explicit Alone(NodeConfig config = {}, std::size_t store_bytes = 1u << 20)
      : store(store_bytes), node(named(std::move(config)), store) {}
  static NodeConfig named(NodeConfig config) {
    config.self = RobotId::from_name("self");
    config.incarnation = kLife;
    config.identity = identity_of(config.self);
    return config;
  }
  void hear(const std::vector<std::uint8_t>& bytes, const Endpoint& from = kStranger) {
    node.on_datagram(now, from, bytes);
  }
  // A datagram of a neighbour that knows us.
  template <class Write>
  void hear_frames(std::uint64_t incarnation, std::uint32_t counter, Write write, const Endpoint& from = kStranger) {
    hear(datagram({wire::DatagramType::unicast, incarnation, kLife, counter}, write), from);
  }
  std::vector<OutgoingDatagram> sent() {
    std::vector<OutgoingDatagram> all;
    OutgoingDatagram one;
    while (node.next_outgoing(one)) all.push_back(one);
    return all;
  }
  // All that is sent to this endpoint in this time, timers included.
  std::vector<OutgoingDatagram> sent_within(Duration time, const Endpoint& to = kStranger) {
    std::vector<OutgoingDatagram> all;
    for (const Instant end = now + time; now < end; now += std::chrono::milliseconds(10)) {
      node.on_timer(now);
      for (const auto& one : sent())
        if (one.to == to) all.push_back(one);
    }
    return all;
  }
  // A DATA frame with a whole record, signed by its log's robot.
  void hear_record(std::uint64_t incarnation, std::uint32_t counter, const Record& record,
                   const Endpoint& from = kStranger, std::uint64_t hash_error = 0) {
    wire::FragmentBuffer scratch;
    wire::Data data = fragment(record, 0, scratch);
    data.body_hash ^= hash_error;
    hear_frames(
        incarnation, counter, [&](auto& out) { out.data(data); }, from);
  }
  void befriend(const std::string& robot = "friend", std::uint64_t incarnation = 5, const Endpoint& from = kStranger) {
    hear(greeting(robot, incarnation, kLife, 1), from);
    sent();
  }
};

// The first frame of this kind in these datagrams, with its datagram's header.
template <class Frame>
std::optional<std::pair<wire::Header, Frame>> first(const std::vector<OutgoingDatagram>& datagrams) {
  wire::Decoder decoder;
  for (const auto& one : datagrams) {
    if (decoder.decode(one.bytes()) != Refusal::count) continue;
    for (const auto& frame : decoder.frames())
      if (const auto* found = std::get_if<Frame>(&frame)) return std::pair(decoder.header(), *found);
  }
  return std::nullopt;
}

}  // namespace onemap::comms::sim
