#include "comms/guard.hpp"

#include <sodium.h>

#include <algorithm>
#include <cassert>
#include <string>

#include "guard_impl.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms {

namespace {
constexpr std::size_t kMaxEvents = 16;

OwnSide own_side(const GuardConfig& config) {
  [[maybe_unused]] const int chosen = sodium_init();  // lets libsodium choose what suits this processor
  OwnSide own;
  config.random(own.static_secret.bytes);
  own.static_public = noise::public_of(own.static_secret);
  own.greeting = signed_greeting(config.identity, own.static_public, config.self, config.incarnation);
  return own;
}

std::string hex(Bytes bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const auto byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

bool same_robot(const Transport& a, const Transport& b) { return a.peer() == b.peer(); }
}  // namespace

Guard::Impl::Impl(GuardConfig config_, Node& node_, Pins& pins_)
    : config(std::move(config_)),
      node(node_),
      memory(node.memory()),
      pins(pins_),
      team(config.team),
      own(own_side(config)),
      group(team.group, config.incarnation, memory) {
  if (config.key_log) config.key_log("GROUP " + hex(team.group.bytes));
  for (const auto& [robot, key] : pins.all()) node.pin(robot, key);
}

std::uint32_t Guard::Impl::new_index() {
  std::array<std::uint8_t, 4> bytes;
  while (true) {
    config.random(bytes);
    const auto index = ByteReader(bytes).get<std::uint32_t>();
    if (index != 0 && !indices.contains(index) && !half_opens.contains(index)) return index;
  }
}

void Guard::Impl::log_keys(const Transport& session) {
  if (!config.key_log) return;
  const auto line = [this](std::uint32_t index, const noise::Key& key) {
    std::array<std::uint8_t, 4> bytes;
    put_little_endian(bytes.data(), index);
    config.key_log("SESSION " + hex(bytes) + " " + hex(key.bytes));
  };
  line(session.own_index(), session.receiving_key());
  line(session.their_index(), session.sending_key());
}

void Guard::Impl::tell(GuardEvent event) {
  if (events.size() < kMaxEvents) events.push_back(event);
}

void Guard::Impl::release(std::optional<Transport>& session) {
  if (session) indices.erase(session->own_index());
  session.reset();
}

Guard::Impl::Links::iterator Guard::Impl::drop(Links::iterator link) {
  release(link->second.current);
  release(link->second.previous);
  if (link->second.initiation) indices.erase(link->second.initiation->index());
  return links.erase(link);
}

// When the table is full, whoever was silent for longest makes room, if it is silent.
Link* Guard::Impl::link_for(const Endpoint& at) {
  constexpr auto kSilent = std::chrono::seconds(20);
  if (const auto known = links.find(at); known != links.end()) return &known->second;
  if (links.size() >= config.max_links) {
    const auto last_sign = [](const auto& entry) { return std::max(entry.second.heard, entry.second.wanted); };
    const auto oldest = std::ranges::min_element(links, {}, last_sign);
    if (now - oldest->second.heard < kSilent && oldest->second.current)
      return refuse(Refusal::neighbours_full), nullptr;
    drop(oldest);
  }
  return &links[at];
}

// Who this is has been proved; whether it may be our neighbour.
Refusal Guard::Impl::vet(const Endpoint& from, const Greeting& greeting) {
  if (greeting.robot == config.self) {  // the node says what it is, and counts it
    node.on_session(now, from, {greeting.robot, greeting.incarnation, 0, 0, 0, false});
    return Refusal::id_conflict;
  }
  Refusal verdict = Refusal::count;
  if (conduct.shut_out(now, greeting.identity)) verdict = Refusal::shut_out;
  const auto pinned = pins.look(greeting.robot, greeting.identity);
  if (pinned == Pins::Verdict::full) verdict = Refusal::pins_full;
  if (pinned == Pins::Verdict::another) {
    verdict = Refusal::other_key;
    tell({GuardEvent::What::other_key, greeting.robot, from, greeting.identity, {}});
  }
  if (verdict != Refusal::count) refuse(verdict);
  return verdict;
}

// Both sides know that this session is there. Of two that were begun at the same time, one by each side, both speak on
// the one that the lower id began, and listen on both.
void Guard::Impl::install(const Endpoint& at, Link& link, Transport session) {
  const auto begun_by_lower = [this](const Transport& t) {
    return (t.role() == noise::Role::initiator) == (config.self < t.peer().robot);
  };
  if (pins.look(session.peer().robot, session.peer().identity) == Pins::Verdict::unknown)
    pins.pin(session.peer().robot, session.peer().identity);
  node.pin(session.peer().robot, session.peer().identity);
  log_keys(session);
  indices[session.own_index()] = at;
  link.attempts = 0;
  link.heard = now;
  link.move.reset();
  if (link.current && !same_robot(*link.current, session)) {  // a former life says nothing more
    release(link.current);
    release(link.previous);
  }
  release(link.previous);
  const bool at_once = link.current && now - link.current->begun() < Initiation::kAttempt;
  if (at_once && begun_by_lower(*link.current) && !begun_by_lower(session)) {
    link.previous.emplace(std::move(session));
  } else {
    link.previous = std::exchange(link.current, std::move(session));
  }
  if (link.initiation && !link.initiation->made()) {
    indices.erase(link.initiation->index());
    link.initiation.reset();
  }
  const Greeting& peer = link.current->peer();
  node.on_session(now, at, {peer.robot, peer.incarnation, 0, 0, 0, false});
}

Guard::Guard(GuardConfig config, Node& node, Pins& pins)
    : impl_(std::make_unique<Impl>(std::move(config), node, pins)) {}
Guard::~Guard() = default;

void Guard::on_datagram(Instant now, const Endpoint& from, std::span<const std::uint8_t> bytes) {
  impl_->now = std::max(impl_->now, now);
  impl_->receive(from, bytes);
}

void Guard::on_timer(Instant now) {
  impl_->now = std::max(impl_->now, now);
  if (now >= impl_->node.next_deadline()) impl_->node.on_timer(now);
  impl_->tick();
}

Instant Guard::next_deadline() const { return impl_->next_deadline(); }
bool Guard::next_outgoing(OutgoingDatagram& datagram) { return impl_->next_outgoing(datagram); }

bool Guard::next_event(GuardEvent& event) {
  if (impl_->events.empty()) return false;
  event = impl_->events.front();
  impl_->events.pop_front();
  return true;
}

Counters Guard::counters() const {
  Counters all = impl_->node.counters();
  const Counters& own = impl_->counters;
  all.datagrams_sent += own.datagrams_sent - impl_->unsent_datagrams;
  all.bytes_sent += own.bytes_sent - impl_->unsent_bytes;
  all.datagrams_received += own.datagrams_received;
  all.bytes_received += own.bytes_received;
  for (std::size_t i = 0; i < kRefusalCount; ++i) all.refused[i] += own.refused[i];
  return all;
}

std::size_t Guard::sessions() const {
  return static_cast<std::size_t>(std::ranges::count_if(impl_->links, [this](const auto& entry) {
    return entry.second.current && !entry.second.current->expired(impl_->now);
  }));
}

}  // namespace onemap::comms
