// What goes to the network.
#include <algorithm>

#include "comms/wire/frames.hpp"
#include "comms/wire/header.hpp"
#include "guard_impl.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
constexpr std::size_t kMaxReplies = 256;
}  // namespace

void Guard::Impl::reply(const Endpoint& to, Bytes bytes) {
  if (replies.size() < kMaxReplies)
    replies.emplace_back(to, std::pmr::vector<std::uint8_t>(bytes.begin(), bytes.end(), &memory));
}

void Guard::Impl::say(const Endpoint& to, Transport& session, Word word, std::uint64_t token) {
  std::array<std::uint8_t, kOwnBytes> datagram;
  session.say(datagram, word, token);
  reply(to, datagram);
}

bool Guard::Impl::next_outgoing(OutgoingDatagram& datagram) {
  while (replies.empty()) {
    if (!node.next_outgoing(datagram)) return false;
    if (seal(datagram)) return true;
    ++unsent_datagrams;
    unsent_bytes += datagram.size + kOverheadBytes - wire::kHeaderBytes;
  }
  datagram.to = replies.front().first;
  datagram.size = replies.front().second.size();
  std::ranges::copy(replies.front().second, datagram.buffer.begin());
  replies.pop_front();
  ++counters.datagrams_sent;
  counters.bytes_sent += datagram.size;
  return true;
}

// The frames stay where they are but for the difference of the headers.
bool Guard::Impl::seal(OutgoingDatagram& datagram) {
  if (datagram.to == config.group) return group.seal(datagram, config.random), true;
  wire::Header header;
  const auto link = links.find(datagram.to);
  const bool written = wire::read_header(datagram.bytes(), header) == Refusal::count;
  const bool usable = written && link != links.end() && link->second.current && !link->second.current->expired(now);
  if (!usable) return want(datagram.to), knock(datagram);
  Transport& session = *link->second.current;
  // Meant for another life than the one that we have a session with.
  if (header.receiver != 0 && header.receiver != session.peer().incarnation) return want(datagram.to), false;
  const std::size_t size = datagram.size - wire::kHeaderBytes;
  std::copy_n(datagram.buffer.begin() + wire::kHeaderBytes, size, datagram.buffer.begin() + kHeaderBytes);
  datagram.size = session.seal(datagram.buffer, size, header.counter);
  link->second.spoke = now;
  return true;
}

// A greeting without a session: anybody of the team can read it, and says HELLO in return. It is a tenth of one.
bool Guard::Impl::knock(OutgoingDatagram& datagram) {
  if (datagram.size != wire::kHeaderBytes + wire::kFrameHeadBytes + wire::kBeaconBytes) return false;
  if (datagram.buffer[wire::kHeaderBytes] != static_cast<std::uint8_t>(FrameType::beacon)) return false;
  group.seal(datagram, config.random);
  counters.bytes_sent += kGroupOverheadBytes - kOverheadBytes;  // the node counted a session's
  return true;
}

void Guard::Impl::want(const Endpoint& at) {
  Link* const link = link_for(at);
  if (link == nullptr) return;
  link->wanted = now;
  if (!link->initiation && now >= link->not_before) begin(at, *link);
}

void Guard::Impl::begin(const Endpoint& at, Link& link) {
  constexpr unsigned kPatientAttempts = 18;  // a minute and a half
  constexpr auto kRest = std::chrono::seconds(16);
  const bool first = link.attempts == 0;
  link.initiation.emplace(now, new_index(), own, team, config.random);
  indices[link.initiation->index()] = at;
  ++link.attempts;
  if (link.attempts >= kPatientAttempts) link.not_before = now + kRest;
  if (now >= link.cookie_until) link.cookie.reset();
  reply(at, link.initiation->take(now, link.cookie));
  if (!first) link.initiation->once_is_enough();
}

}  // namespace onemap::comms
