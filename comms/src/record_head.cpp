#include "comms/record_head.hpp"

#include <sodium.h>

#include <algorithm>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

namespace {
constexpr std::array<std::uint8_t, 16> kContext{'o', 'n', 'e', 'm', 'a', 'p', ' ', 'r',
                                                'e', 'c', 'o', 'r', 'd', ' ', '2', 0};

template <std::size_t N>
std::uint8_t* put(std::uint8_t* at, const std::array<std::uint8_t, N>& bytes) {
  return std::copy(bytes.begin(), bytes.end(), at);
}
}  // namespace

Hash digest_of(std::span<const std::uint8_t> bytes) {
  Hash hash;
  crypto_generichash(hash.data(), hash.size(), bytes.data(), bytes.size(), nullptr, 0);
  return hash;
}

RecordHead head_of(const Record& record) {
  RecordHead head{record.id, record.kind,          static_cast<std::uint32_t>(record.body.size()),
                  {},        record.seal.previous, record.seal.replaces};
  if (record.dropped)
    head.bytes = record.dropped->bytes, head.body = record.dropped->digest;
  else
    head.body = digest_of(record.body);
  return head;
}

std::array<std::uint8_t, kSignedHeadBytes> signed_bytes(const RecordHead& head) {
  std::array<std::uint8_t, kSignedHeadBytes> out{};
  std::uint8_t* at = put(out.data(), kContext);
  at = put(at, head.id.log.robot.bytes);
  at = put_little_endian(at, head.id.log.lane);
  at = put_little_endian(at, head.id.log.incarnation);
  at = put_little_endian(at, head.id.seq);
  at = put_little_endian(at, head.kind);
  at = put_little_endian(at, head.bytes);
  at = put(at, head.body);
  at = put(at, head.previous);
  put_little_endian(at, head.replaces);
  return out;
}

Hash hash_of(const RecordHead& head) { return digest_of(signed_bytes(head)); }

Record without_body(const Record& record) {
  const RecordHead head = head_of(record);
  return {record.id, record.kind, {}, record.seal, DroppedBody{head.bytes, head.body}};
}

Hash seal(Record& record, const Hash& previous, const Identity& author) {
  record.seal.previous = record.id.seq == 0 ? author.public_key() : previous;
  const auto bytes = signed_bytes(head_of(record));
  record.seal.signature = author.sign(bytes);
  return digest_of(bytes);
}

bool signed_by(const PublicKey& key, const RecordHead& head, const Signature& signature) {
  return verify(key, signed_bytes(head), signature);
}

}  // namespace onemap::comms
