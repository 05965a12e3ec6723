#include "session/transport.hpp"

#include <algorithm>
#include <cassert>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
constexpr std::uint32_t kFramesDomain = 0, kOwnDomain = 1;  // of nonces: each has its own count

void write_header(MutableBytes datagram, Type type, std::uint32_t index, std::uint64_t counter) {
  write_head(datagram, type);
  put_little_endian(put_little_endian(&datagram[kHeadBytes], index), counter);
}
}  // namespace

Transport::Transport(Instant begun, const Ends& ends, const noise::Handshake& ended) : begun_(begun), ends_(ends) {
  const auto [from_initiator, from_responder] = ended.split();
  const bool first = ends.role == noise::Role::initiator;
  sending_ = first ? from_initiator : from_responder;
  receiving_ = first ? from_responder : from_initiator;
}

std::size_t Transport::seal(MutableBytes datagram, std::size_t size, std::uint32_t counter) {
  assert(datagram.size() >= kOverheadBytes + size);
  const auto ahead = static_cast<std::int32_t>(counter - static_cast<std::uint32_t>(last_));
  last_ = sealed_ == 0 ? counter : last_ + static_cast<std::uint64_t>(std::max(ahead, 1));
  ++sealed_;
  write_header(datagram, Type::frames, ends_.their_index, last_);
  noise::seal(sending_, kFramesDomain, last_, datagram.first(kHeaderBytes), datagram.subspan(kHeaderBytes, size),
              datagram.subspan(kHeaderBytes, size + kTagBytes));
  return kOverheadBytes + size;
}

std::size_t Transport::say(MutableBytes datagram, Word word, std::uint64_t token) {
  std::array<std::uint8_t, kOwnPlainBytes> plain{static_cast<std::uint8_t>(word)};
  put_little_endian(&plain[1], token);
  write_header(datagram, Type::own, ends_.their_index, ++own_last_);
  noise::seal(sending_, kOwnDomain, own_last_, datagram.first(kHeaderBytes), plain,
              datagram.subspan(kHeaderBytes, plain.size() + kTagBytes));
  return kOwnBytes;
}

Refusal Transport::open(Bytes datagram, MutableBytes plain) {
  const std::uint64_t counter = counter_of(datagram);
  if (!noise::open(receiving_, kFramesDomain, counter, datagram.first(kHeaderBytes), datagram.subspan(kHeaderBytes),
                   plain))
    return Refusal::bad_seal;
  switch (window_.accept(counter)) {
    case ReplayWindow::Verdict::duplicate:
      return Refusal::duplicate;
    case ReplayWindow::Verdict::too_old:
      return Refusal::too_old;
    case ReplayWindow::Verdict::fresh:
      break;
  }
  return Refusal::count;
}

Refusal Transport::hear(Bytes datagram, Said& said) {
  const std::uint64_t counter = counter_of(datagram);
  std::array<std::uint8_t, kOwnPlainBytes> plain;
  if (!noise::open(receiving_, kOwnDomain, counter, datagram.first(kHeaderBytes), datagram.subspan(kHeaderBytes),
                   plain))
    return Refusal::bad_seal;
  if (counter <= their_last_) return Refusal::duplicate;
  their_last_ = counter;
  ByteReader in(plain);
  const auto word = in.get<std::uint8_t>();
  if (word > static_cast<std::uint8_t>(Word::probe_answer)) return Refusal::bad_frame;
  said = {static_cast<Word>(word), in.get<std::uint64_t>()};
  return Refusal::count;
}

}  // namespace onemap::comms
