// What is told of our frontier.
#include <algorithm>

#include "node_impl.hpp"

namespace onemap::comms {

namespace {
// Of what is not asked for again when it is lost.
unsigned copies_for(const Peer& peer) { return PushQueue::copies(std::max(peer.rate.loss(), peer.session.loss())); }
}  // namespace

void Node::Impl::tell_all(Peer& peer) {
  for (const auto& [log, count] : store.frontier())
    if (told(log) > 0) peer.outbox.tell(log, now, true);
}

void Node::Impl::put_have(wire::Encoder& out, Peer& peer) {
  have_scratch.clear();
  for (const LogId& log : peer.outbox.changed())
    if (told(log) > 0) have_scratch.push_back({log, told(log)});
  const std::size_t n = out.have(frontier_digest, have_scratch);
  if (n == 0) return;
  peer.outbox.told(now, have_scratch, n, copies_for(peer));
  count_sent(FrameType::have);
}

// By what it told, it lacks these: that it was told of them may have got lost. Where that happens, some of them with
// each beacon save a request and its answer.
void Node::Impl::put_lacking(wire::Encoder& out, Peer& peer) {
  constexpr std::size_t kMost = 8;
  if (peer.frontier.claimed_digest() == frontier_digest || copies_for(peer) == 1) return;
  const VersionVector& logs = store.frontier();
  have_scratch.clear();
  auto it = logs.upper_bound(peer.outbox.lacking_cursor);
  for (std::size_t i = 0; i < logs.size() && have_scratch.size() < kMost; ++i, ++it) {
    if (it == logs.end()) it = logs.begin();
    if (told(it->first) > peer.frontier.count(it->first)) have_scratch.push_back({it->first, told(it->first)});
  }
  if (have_scratch.empty()) return;
  const std::size_t n = out.have(frontier_digest, have_scratch);
  if (n == 0) return;
  peer.outbox.lacking_cursor = have_scratch[n - 1].log;
  count_sent(FrameType::have);
}

}  // namespace onemap::comms
