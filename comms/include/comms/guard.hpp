#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "comms/counters.hpp"
#include "comms/datagram_port.hpp"
#include "comms/identity.hpp"
#include "comms/node.hpp"
#include "comms/pins.hpp"
#include "comms/secret.hpp"

namespace onemap::comms {

struct GuardConfig {
  RobotId self;                   // as the node's config
  std::uint64_t incarnation = 1;  // as the node's config
  std::optional<Endpoint> group;  // as the node's config
  TeamKey team;
  Identity identity;
  std::function<void(std::span<std::uint8_t>)> random;  // fills with bytes that nobody can guess
  std::function<void(std::string_view line)> key_log;   // the keys of sessions, for looking into traffic; null: none
  std::size_t max_links = 64;                           // addresses with which sessions are held
};

// What people should hear of.
struct GuardEvent {
  enum class What {
    other_key,  // a robot with this name has another key than the one that the name belongs to
    shut_out    // this robot spoke nonsense too often: nothing is taken from it for a while
  };
  What what = What::other_key;
  RobotId robot;
  Endpoint where;
  PublicKey key{};     // that it showed
  Duration penalty{};  // of shut_out
};

// Between a Node and the network in a team with a key (comms/PROTOCOL.md): a session for every neighbour, made by a
// Noise handshake that needs the team's key and proves the robot's own, and every datagram sealed. To whoever does not
// know the team's key this robot is silent. A pure function of bytes, `now` and the random bytes that it is given; it
// is called as a Node is, and calls the Node. The node's config must say that it is sealed.
class Guard {
 public:
  // The node and the pins must outlive it.
  Guard(GuardConfig config, Node& node, Pins& pins);
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  void on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes);
  void on_timer(Instant now);
  Instant next_deadline() const;
  bool next_outgoing(OutgoingDatagram& datagram);  // false: nothing to send at the last `now`
  bool next_event(GuardEvent& event);

  Counters counters() const;     // the node's with this one's: all that was on the wire
  std::size_t sessions() const;  // that can be used now

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::comms
