#include "comms/wire/header.hpp"

#include "hal/base/bytes.hpp"

namespace onemap::comms::wire {

namespace {
constexpr std::uint8_t kMagicMask = 0xF0;
}  // namespace

Refusal read_header(std::span<const std::uint8_t> datagram, Header& header) {
  if (datagram.size() < kHeaderBytes) return Refusal::too_short;
  if ((datagram[0] & kMagicMask) != (kMagicAndVersion & kMagicMask)) return Refusal::bad_magic;
  if (datagram[0] != kMagicAndVersion) return Refusal::bad_version;
  if (datagram.size() > kHeaderBytes + kMaxFramesBytes) return Refusal::too_long;
  ByteReader in(datagram.subspan(1));
  header.type = static_cast<DatagramType>(in.get<std::uint8_t>());
  if (header.type != DatagramType::unicast && header.type != DatagramType::group) return Refusal::bad_type;
  if (in.get<std::uint16_t>() != 0) return Refusal::bad_reserved;
  header.sender = in.get<std::uint64_t>();
  header.receiver = in.get<std::uint64_t>();
  header.counter = in.get<std::uint32_t>();
  if (header.sender == 0 || header.counter == 0) return Refusal::bad_frame;
  return is_life(header.sender) ? Refusal::count : Refusal::bad_incarnation;
}

void write_header(std::span<std::uint8_t, kMaxDatagramBytes> datagram, const Header& header) {
  std::uint8_t* at = datagram.data();
  at = put_little_endian(at, kMagicAndVersion);
  at = put_little_endian(at, static_cast<std::uint8_t>(header.type));
  at = put_little_endian(at, std::uint16_t{0});
  at = put_little_endian(at, header.sender);
  at = put_little_endian(at, header.receiver);
  put_little_endian(at, header.counter);
}

}  // namespace onemap::comms::wire
