// What comes from the network. Cheap checks first: garbage ends before anything is computed for it.
#include <algorithm>

#include "guard_impl.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
constexpr std::size_t kMaxHalfOpen = 64, kHalfOpenOfOneAddress = 8, kManyHalfOpen = 32;
constexpr auto kProbeGap = std::chrono::seconds(1);

bool mac_is_good(const TeamSecrets& team, Bytes datagram, std::size_t at) {
  return equal_in_constant_time(mac_of(team.mac.bytes, datagram.first(at)), datagram.subspan(at, kMacBytes));
}
}  // namespace

void Guard::Impl::receive(const Endpoint& from, Bytes bytes) {
  Type type{};
  const Refusal verdict = read_head(bytes, type);
  const bool counted_by_node = verdict == Refusal::count && (type == Type::frames || type == Type::group);
  if (!counted_by_node) {
    ++counters.datagrams_received;
    counters.bytes_received += bytes.size();
  }
  if (verdict != Refusal::count) return refuse(verdict);
  switch (type) {
    case Type::hello:
      return on_hello(from, bytes);
    case Type::answer:
      return on_answer(from, bytes);
    case Type::proof:
      return on_proof(from, bytes);
    case Type::cookie:
      return on_cookie(from, bytes);
    case Type::frames:
      return on_frames(from, bytes);
    case Type::own:
      return on_own(from, bytes);
    case Type::group:
      return on_group(from, bytes);
  }
}

void Guard::Impl::on_hello(const Endpoint& from, Bytes bytes) {
  if (!mac_is_good(team, bytes, kHelloMac1At)) return refuse(Refusal::bad_mac);
  const auto again = std::ranges::find_if(
      half_opens, [&](const auto& entry) { return entry.second.from() == from && entry.second.begun_by(bytes); });
  if (again != half_opens.end()) return reply(from, again->second.answer());
  load.came(now);
  if (half_opens.size() >= kManyHalfOpen) load.be_heavy(now);
  if (load.heavy(now) && !cookies.pays(now, from, bytes)) {
    refuse(Refusal::under_load);
    return reply(from, cookies.reply(now, from, bytes, team.cookie, config.random));
  }
  if (!load.may_work(now)) return refuse(Refusal::busy);
  const std::uint32_t index = new_index();
  HalfOpen half(now, from, index, own, team, config.random);
  if (!half.begin(bytes, own, team)) return refuse(Refusal::bad_handshake);
  make_room_for(from);
  reply(from, half_opens.emplace(index, std::move(half)).first->second.answer());
}

// The oldest one makes room: first of the same address, so that one address does not fill the table.
void Guard::Impl::make_room_for(const Endpoint& from) {
  const auto begun = [](const auto& entry) { return entry.second.begun(); };
  std::size_t of_address = 0;
  auto oldest = half_opens.end();
  for (auto it = half_opens.begin(); it != half_opens.end(); ++it) {
    if (it->second.from().address != from.address) continue;
    ++of_address;
    if (oldest == half_opens.end() || it->second.begun() < oldest->second.begun()) oldest = it;
  }
  if (of_address >= kHalfOpenOfOneAddress)
    half_opens.erase(oldest);
  else if (half_opens.size() >= kMaxHalfOpen)
    half_opens.erase(std::ranges::min_element(half_opens, {}, begun));
}

void Guard::Impl::on_answer(const Endpoint& from, Bytes bytes) {
  if (!mac_is_good(team, bytes, kAnswerBytes - kMacBytes)) return refuse(Refusal::bad_mac);
  const auto at = links.find(from);
  if (at == links.end() || !at->second.initiation || at->second.initiation->index() != index_at(bytes, 8))
    return refuse(Refusal::bad_handshake);
  Initiation& initiation = *at->second.initiation;
  if (initiation.made()) {
    if (!initiation.answered_by(bytes)) refuse(Refusal::bad_handshake);
    return;  // the proof goes out again by the clock
  }
  if (!load.may_work(now)) return refuse(Refusal::busy);
  Greeting greeting;
  if (const Refusal read = initiation.read_answer(bytes, greeting); read != Refusal::count) return refuse(read);
  if (vet(from, greeting) != Refusal::count) return;
  if (!initiation.prove(now, bytes, greeting, own, team)) return refuse(Refusal::bad_handshake);
  reply(from, initiation.take(now, std::nullopt));
}

void Guard::Impl::on_proof(const Endpoint& from, Bytes bytes) {
  if (!mac_is_good(team, bytes, kProofBytes - kMacBytes)) return refuse(Refusal::bad_mac);
  const std::uint32_t index = index_at(bytes, 8);
  const Bytes mac = bytes.last(kMacBytes);
  const auto half = half_opens.find(index);
  if (half == half_opens.end() || half->second.from() != from) {
    const auto link = links.find(from);
    const bool again = link != links.end() && equal_in_constant_time(link->second.proof_mac, mac);
    Transport* const session = again ? link->second.of(index) : nullptr;
    if (session == nullptr) return refuse(Refusal::bad_handshake);
    return say(from, *session, Word::here, 0);  // the first sign of us was lost
  }
  if (!load.may_work(now)) return refuse(Refusal::busy);
  Greeting greeting;
  if (const Refusal read = half->second.read_proof(bytes, greeting); read != Refusal::count) return refuse(read);
  Transport session = half->second.made(now, greeting);
  half_opens.erase(half);
  if (vet(from, greeting) != Refusal::count) return;
  Link* const link = link_for(from);
  if (link == nullptr) return;
  std::copy(mac.begin(), mac.end(), link->proof_mac.begin());
  install(from, *link, std::move(session));
  say(from, *link->of(index), Word::here, 0);
}

void Guard::Impl::on_cookie(const Endpoint& from, Bytes bytes) {
  const auto at = links.find(from);
  Mac cookie;
  if (at == links.end() || !at->second.initiation || at->second.initiation->made() ||
      at->second.initiation->index() != index_at(bytes, kHeadBytes) ||
      !at->second.initiation->take_cookie(bytes, team, cookie))
    return refuse(Refusal::bad_cookie);
  Link& link = at->second;
  const bool news = link.cookie != cookie;
  link.cookie = cookie;
  link.cookie_until = now + CookieJar::kLife;
  if (news) link.initiation->send_soon(now);
}

// A datagram of this session is authentic: it is there at both ends, if that was not known yet.
void Guard::Impl::authentic(Links::iterator link, std::uint32_t index) {
  Link& l = link->second;
  l.heard = now;
  if (!l.initiation || !l.initiation->made() || l.initiation->index() != index) return;
  Transport session = std::move(*l.initiation->made());
  l.initiation.reset();
  install(link->first, l, std::move(session));
}

void Guard::Impl::on_frames(const Endpoint& from, Bytes bytes) {
  const std::uint32_t index = index_at(bytes, kHeadBytes);
  const auto known = indices.find(index);
  const auto link = known == indices.end() ? links.end() : links.find(known->second);
  Transport* session = link == links.end() ? nullptr : link->second.of(index);
  const MutableBytes frames = MutableBytes(plain).first(bytes.size() - kOverheadBytes);
  Refusal verdict = Refusal::unknown_session;
  if (session != nullptr && !session->expired(now)) verdict = session->open(bytes, frames);
  if (verdict != Refusal::count) {
    ++counters.datagrams_received;
    counters.bytes_received += bytes.size();
    if (verdict == Refusal::unknown_session) meet_again(from, bytes.size());
    return refuse(verdict);
  }
  authentic(link, index);
  session = link->second.of(index);
  const Greeting peer = session->peer();
  if (bytes.size() >= kOwnBytes) follow(link, from, counter_of(bytes), index);  // it gets no more than it sent
  const Endpoint at = link->first;
  const Node::Proof proof{peer.robot, peer.incarnation, counter_of(bytes), bytes.size(), session->loss(), false};
  judge(at, peer.identity, peer.robot, node.on_sealed(now, at, proof, frames));
}

// Somebody whom we greet, or who should be there, speaks in a session that is not here (any longer): one that we lost,
// or that we never heard had been made. Anybody can say so, so it is worth a greeting a second, and where no peer was
// configured to be no more bytes than came.
void Guard::Impl::meet_again(const Endpoint& from, std::size_t bytes) {
  constexpr auto kGap = std::chrono::seconds(1);
  const auto at = links.find(from);
  if (at == links.end()) return;
  Link& link = at->second;
  link.unknown_bytes += bytes;
  if (link.unknown_bytes < kHelloBytes && !node.is_configured(from)) return;
  link.unknown_bytes = 0;
  if (link.initiation && !link.initiation->over(now)) return link.initiation->is_there(now);
  if (now < link.met_again + kGap) return;
  link.met_again = now;
  if (link.initiation) indices.erase(link.initiation->index());
  begin(from, link);
}

// Whoever has the team's key and its own and sends what is no frame is broken, or lies.
void Guard::Impl::judge(const Endpoint& at, const PublicKey& who, const RobotId& robot, Refusal verdict) {
  if (verdict != Refusal::bad_frame && verdict != Refusal::bad_robot_id && verdict != Refusal::wrong_name) return;
  const auto penalty = conduct.strike(now, who);
  if (!penalty) return;
  tell({GuardEvent::What::shut_out, robot, at, who, *penalty});
  for (auto link = links.begin(); link != links.end();)
    link = link->second.current && link->second.current->peer().identity == who ? drop(link) : std::next(link);
}

// It speaks from another address than it did. That it is it there is no proof that it can be reached there: somebody on
// the way can send on what he caught. So the new address has to answer first.
void Guard::Impl::follow(Links::iterator link, const Endpoint& from, std::uint64_t counter, std::uint32_t index) {
  Link& l = link->second;
  Transport* const session = l.of(index);
  if (from == link->first || !l.current || session != &*l.current || !session->is_newest(counter)) return;
  if (l.move && l.move->to == from && now - l.move->asked < kProbeGap) return;
  std::array<std::uint8_t, 8> token;
  config.random(token);
  l.move = Link::Move{from, ByteReader(token).get<std::uint64_t>(), now};
  say(from, *session, Word::probe, l.move->token);
}

void Guard::Impl::on_own(const Endpoint& from, Bytes bytes) {
  const std::uint32_t index = index_at(bytes, kHeadBytes);
  const auto known = indices.find(index);
  const auto link = known == indices.end() ? links.end() : links.find(known->second);
  Transport* const session = link == links.end() ? nullptr : link->second.of(index);
  if (session == nullptr || session->expired(now)) return refuse(Refusal::unknown_session);
  Transport::Said said{};
  if (const Refusal verdict = session->hear(bytes, said); verdict != Refusal::count) return refuse(verdict);
  authentic(link, index);
  if (said.word == Word::probe) say(from, *link->second.of(index), Word::probe_answer, said.token);
  const auto& asked = link->second.move;
  if (said.word == Word::probe_answer && asked && asked->to == from && asked->token == said.token) move(link);
}

void Guard::Impl::move(Links::iterator link) {
  const Endpoint from = link->first, to = link->second.move->to;
  link->second.move.reset();
  if (const auto there = links.find(to); there != links.end()) {
    const auto& lives = there->second.current;  // this one has just answered from there
    if (lives && lives->peer().robot != link->second.current->peer().robot) return;
    drop(there);
  }
  auto entry = links.extract(link);
  entry.key() = to;
  for (auto& [index, at] : indices)
    if (at == from) at = to;
  links.insert(std::move(entry));
  node.on_moved(now, from, to);
}

void Guard::Impl::on_group(const Endpoint& from, Bytes bytes) {
  GroupSeal::Opened opened;
  if (const Refusal verdict = group.open(now, bytes, plain, opened); verdict != Refusal::count) {
    ++counters.datagrams_received;
    counters.bytes_received += bytes.size();
    return refuse(verdict);
  }
  constexpr auto kLowerIdFirst = std::chrono::milliseconds(500);
  const auto known = links.find(from);
  if (!config.group && known == links.end()) {  // nobody whom we greet: it is we who would be made to speak there
    ++counters.datagrams_received;
    counters.bytes_received += bytes.size();
    return refuse(Refusal::stranger);
  }
  if (known != links.end()) {
    if (known->second.initiation) known->second.initiation->is_there(now);
    if (!known->second.current) known->second.not_before = std::min(known->second.not_before, now + kLowerIdFirst);
  } else if (opened.robot < config.self) {
    if (Link* const link = link_for(from); link != nullptr) link->not_before = now + kLowerIdFirst;
  }
  node.on_sealed(now, from, {opened.robot, opened.incarnation, opened.counter, bytes.size(), 0.0, true}, opened.frames);
}

}  // namespace onemap::comms
