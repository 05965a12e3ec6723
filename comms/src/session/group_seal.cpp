#include "session/group_seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <tuple>

#include "comms/wire/frames.hpp"
#include "comms/wire/header.hpp"
#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
static_assert(kGroupNonceAt + crypto_aead_xchacha20poly1305_ietf_NPUBBYTES == kGroupSealedAt);
constexpr std::size_t kRobotAt = wire::kFrameHeadBytes;  // in the frames, when the first is a BEACON

bool begins_with_a_beacon(Bytes frames) {
  return frames.size() >= wire::kFrameHeadBytes + wire::kBeaconBytes &&
         frames[0] == static_cast<std::uint8_t>(FrameType::beacon);
}
}  // namespace

void GroupSeal::seal(OutgoingDatagram& datagram, const RandomBytes& random) {
  const std::size_t frames = datagram.size - wire::kHeaderBytes;
  std::array<std::uint8_t, kMaxDatagramBytes> plain;
  std::uint8_t* const at = put_little_endian(put_little_endian(plain.data(), incarnation_), ++counter_);
  std::copy_n(datagram.buffer.begin() + wire::kHeaderBytes, frames, at);
  write_head(datagram.buffer, Type::group);
  random(MutableBytes(datagram.buffer).subspan(kGroupNonceAt, kGroupSealedAt - kGroupNonceAt));
  crypto_aead_xchacha20poly1305_ietf_encrypt(&datagram.buffer[kGroupSealedAt], nullptr, plain.data(),
                                             kGroupPlainHeadBytes + frames, datagram.buffer.data(), kHeadBytes, nullptr,
                                             &datagram.buffer[kGroupNonceAt], key_.bytes.data());
  datagram.size = kGroupOverheadBytes + frames;
}

Refusal GroupSeal::open(Instant now, Bytes datagram, MutableBytes room, Opened& opened) {
  const std::size_t size = datagram.size() - kGroupSealedAt - kTagBytes;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(room.data(), nullptr, nullptr, datagram.data() + kGroupSealedAt,
                                                 size + kTagBytes, datagram.data(), kHeadBytes,
                                                 datagram.data() + kGroupNonceAt, key_.bytes.data()) != 0)
    return Refusal::bad_seal;
  ByteReader in(Bytes(room).first(size));
  opened.incarnation = in.get<std::uint64_t>();
  opened.counter = in.get<std::uint64_t>();
  opened.frames = in.bytes(in.remaining());
  if (!begins_with_a_beacon(opened.frames)) return Refusal::bad_frame;
  std::copy_n(opened.frames.begin() + kRobotAt, opened.robot.bytes.size(), opened.robot.bytes.begin());
  if (!opened.robot.valid()) return Refusal::bad_robot_id;
  if (!wire::is_life(opened.incarnation)) return Refusal::bad_incarnation;
  return is_news(now, opened) ? Refusal::count : Refusal::duplicate;
}

bool GroupSeal::is_news(Instant now, const Opened& opened) {
  if (!senders_.contains(opened.robot) && senders_.size() >= kMost)
    senders_.erase(std::ranges::min_element(senders_, {}, [](const auto& entry) { return entry.second.heard; }));
  Sender& sender = senders_[opened.robot];
  if (std::tie(opened.incarnation, opened.counter) <= std::tie(sender.incarnation, sender.counter)) return false;
  sender = {opened.incarnation, opened.counter, now};
  return true;
}

}  // namespace onemap::comms
