#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "comms/guard.hpp"
#include "memory/memory.hpp"
#include "session/conduct.hpp"
#include "session/cookies.hpp"
#include "session/group_seal.hpp"
#include "session/half_open.hpp"
#include "session/link.hpp"
#include "session/load.hpp"

namespace onemap::comms {

struct Guard::Impl {
  Impl(GuardConfig config_, Node& node_, Pins& pins_);
  using Links = std::pmr::map<Endpoint, Link>;

  // guard.cpp: sessions come and go
  void install(const Endpoint& at, Link& link, Transport session);
  Refusal vet(const Endpoint& from, const Greeting& greeting);
  Link* link_for(const Endpoint& at);
  Links::iterator drop(Links::iterator link);
  void release(std::optional<Transport>& session);
  std::uint32_t new_index();
  void log_keys(const Transport& session);
  void tell(GuardEvent event);

  // guard_receive.cpp
  void receive(const Endpoint& from, Bytes bytes);
  void on_hello(const Endpoint& from, Bytes bytes);
  void on_answer(const Endpoint& from, Bytes bytes);
  void on_proof(const Endpoint& from, Bytes bytes);
  void on_cookie(const Endpoint& from, Bytes bytes);
  void on_frames(const Endpoint& from, Bytes bytes);
  void on_own(const Endpoint& from, Bytes bytes);
  void meet_again(const Endpoint& from, std::size_t bytes);
  void on_group(const Endpoint& from, Bytes bytes);
  void make_room_for(const Endpoint& from);
  void authentic(Links::iterator link, std::uint32_t index);
  void judge(const Endpoint& at, const PublicKey& who, const RobotId& robot, Refusal verdict);
  void follow(Links::iterator link, const Endpoint& from, std::uint64_t counter, std::uint32_t index);
  void move(Links::iterator link);
  void refuse(Refusal reason) { counters.refuse(reason); }

  // guard_send.cpp
  bool next_outgoing(OutgoingDatagram& datagram);
  bool seal(OutgoingDatagram& datagram);
  bool knock(OutgoingDatagram& datagram);
  void want(const Endpoint& at);
  void begin(const Endpoint& at, Link& link);
  void reply(const Endpoint& to, Bytes bytes);
  void say(const Endpoint& to, Transport& session, sealed::Word word, std::uint64_t token);

  // guard_timer.cpp
  void tick();
  void tick(const Endpoint& at, Link& link);
  bool should_renew(const Link& link) const;
  Instant next_deadline() const;

  GuardConfig config;
  Node& node;
  Memory& memory;  // the node's
  Pins& pins;
  TeamSecrets team;
  OwnSide own;
  GroupSeal group;
  Instant now{}, next_look{};
  Links links{&memory};
  std::pmr::map<std::uint32_t, Endpoint> indices{&memory};  // of sessions and initiations
  std::pmr::map<std::uint32_t, HalfOpen> half_opens{&memory};
  CookieJar cookies;
  Conduct conduct{memory};
  Load load;
  Counters counters;                                     // this one's part
  std::uint64_t unsent_datagrams = 0, unsent_bytes = 0;  // of the node, for want of a session
  std::pmr::deque<std::pair<Endpoint, std::pmr::vector<std::uint8_t>>> replies{&memory};
  std::pmr::deque<GuardEvent> events{&memory};
  std::array<std::uint8_t, kMaxDatagramBytes> plain{};
};

}  // namespace onemap::comms
