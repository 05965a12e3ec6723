#include "session/sealed_wire.hpp"

#include "hal/base/bytes.hpp"

namespace onemap::comms::sealed {

namespace {
constexpr std::uint8_t kMagicMask = 0xF0, kPlainVersion = 0xB1;

bool size_fits(Type type, std::size_t size) {
  switch (type) {
    case Type::hello:
      return size == kHelloBytes;
    case Type::answer:
      return size == kAnswerBytes;
    case Type::proof:
      return size == kProofBytes;
    case Type::cookie:
      return size == kCookieBytes;
    case Type::own:
      return size == kOwnBytes;
    case Type::frames:
      return size >= kOverheadBytes;
    case Type::group:
      return size >= kGroupOverheadBytes;
  }
  return false;
}
bool known(std::uint8_t type) {
  return (type >= static_cast<std::uint8_t>(Type::hello) && type <= static_cast<std::uint8_t>(Type::own)) ||
         type == static_cast<std::uint8_t>(Type::group);
}
}  // namespace

Refusal read_head(Bytes datagram, Type& type) {
  if (datagram.size() < kHeadBytes) return Refusal::too_short;
  if (datagram.size() > kMaxDatagramBytes) return Refusal::too_long;
  if ((datagram[0] & kMagicMask) != (kMagicAndVersion & kMagicMask)) return Refusal::bad_magic;
  if (datagram[0] == kPlainVersion) return Refusal::not_sealed;
  if (datagram[0] != kMagicAndVersion) return Refusal::bad_version;
  if (!known(datagram[1])) return Refusal::bad_type;
  if (datagram[2] != 0 || datagram[3] != 0) return Refusal::bad_reserved;
  type = static_cast<Type>(datagram[1]);
  return size_fits(type, datagram.size()) ? Refusal::count : Refusal::bad_size;
}

void write_head(MutableBytes datagram, Type type) {
  datagram[0] = kMagicAndVersion;
  datagram[1] = static_cast<std::uint8_t>(type);
  datagram[2] = datagram[3] = 0;
}

std::uint32_t index_at(Bytes datagram, std::size_t at) { return ByteReader(datagram.subspan(at)).get<std::uint32_t>(); }

std::uint64_t counter_of(Bytes datagram) { return ByteReader(datagram.subspan(8)).get<std::uint64_t>(); }

}  // namespace onemap::comms::sealed
