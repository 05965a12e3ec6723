// What comes through a Guard: who speaks is proved, and no datagram comes twice.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
// What a plain datagram of this sender would have said.
wire::Header header_of(const Node::Proof& proof, std::uint64_t own_life) {
  if (proof.group) return {wire::DatagramType::group, proof.incarnation, 0, 0};
  return {wire::DatagramType::unicast, proof.incarnation, own_life, 0};
}

bool names_another(std::span<const wire::Frame> frames, const RobotId& robot) {
  return std::any_of(frames.begin(), frames.end(), [&](const wire::Frame& frame) {
    const auto* beacon = std::get_if<wire::Beacon>(&frame);
    return beacon != nullptr && beacon->robot != robot;
  });
}
}  // namespace

Refusal Node::Impl::receive_sealed(const Endpoint& from, const Proof& proof, std::span<const std::uint8_t> frames) {
  ++counters.datagrams_received;
  counters.bytes_received += proof.bytes;
  const Refusal verdict = decoder.decode(header_of(proof, config.incarnation), frames);
  if (verdict != Refusal::count) return refuse(verdict), verdict;
  if (names_another(decoder.frames(), proof.robot)) return refuse(Refusal::wrong_name), Refusal::wrong_name;
  Peer* const peer = speaker(from, proof.bytes, frames);
  if (peer == nullptr) return last_refusal;
  if (proof.group && !peer->who.alive) {  // worth a greeting, and for that a session
    ++counters.frames_received[index_of(FrameType::beacon)];
    peer->who.last_heard = now;
    peer->outbox.beacon_due = true;
    return Refusal::count;
  }
  if (!proof.group) {
    peer->who.last_heard = now;
    peer->session.heard_sealed(proof.loss);
  }
  hear(*peer, {!proof.group, proof.counter}, proof.bytes);
  return Refusal::count;
}

Refusal Node::Impl::begin_session(const Endpoint& from, const Proof& proof) {
  last_refusal = Refusal::count;
  Peer* const peer = admit_greeting(from, header_of(proof, config.incarnation), proof.robot);
  if (peer == nullptr) return last_refusal;
  for (auto& [endpoint, other] : peers)
    if (&other != peer && other.who.alive && other.who.robot == proof.robot) peer_down(other);
  peer->ever_heard = true;
  peer->who.last_heard = now;
  if (peer->who.alive)
    peer->outbox.beacon_due = true;
  else
    peer_up(*peer);
  return Refusal::count;
}

Refusal Node::on_session(Instant now, const Endpoint& from, const Proof& proof) {
  impl_->advance(now);
  return impl_->begin_session(from, proof);
}

Refusal Node::on_sealed(Instant now, const Endpoint& from, const Proof& proof, std::span<const std::uint8_t> frames) {
  impl_->advance(now);
  return impl_->receive_sealed(from, proof, frames);
}

void Node::on_moved(Instant now, const Endpoint& from, const Endpoint& to) {
  impl_->advance(now);
  impl_->moved(from, to);
}

}  // namespace onemap::comms
