#include "comms/wire/payload.hpp"

#define XXH_STATIC_LINKING_ONLY  // its state, so that it takes no memory of its own
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <span>

#include "hal/base/bytes.hpp"

namespace onemap::comms::wire {

namespace {
std::array<std::uint8_t, kSealBytes> bytes_of(const Seal& seal) {
  std::array<std::uint8_t, kSealBytes> out{};
  std::uint8_t* at = std::copy(seal.previous.begin(), seal.previous.end(), out.data());
  at = put_little_endian(at, seal.replaces);
  std::copy(seal.signature.begin(), seal.signature.end(), at);
  return out;
}
}  // namespace

std::uint64_t payload_hash(const Record& record) {
  const auto seal = bytes_of(record.seal);
  XXH3_state_t state;
  XXH3_INITSTATE(&state);
  XXH3_64bits_reset_withSeed(&state, record.kind);
  XXH3_64bits_update(&state, record.body.data(), record.body.size());
  XXH3_64bits_update(&state, seal.data(), seal.size());
  return XXH3_64bits_digest(&state);
}

std::span<const std::uint8_t> fragment_of(const Record& record, std::uint32_t fragment, FragmentBuffer& scratch) {
  const std::size_t from = std::size_t{fragment} * kFragmentBytes;
  const std::size_t end = std::min<std::size_t>(from + kFragmentBytes, payload_bytes(record));
  const std::size_t body = record.body.size();
  if (end <= body) return std::span(record.body).subspan(from, end - from);
  const auto seal = bytes_of(record.seal);
  std::size_t n = 0;
  for (std::size_t at = from; at < end; ++at) scratch[n++] = at < body ? record.body[at] : seal[at - body];
  return std::span(scratch).first(n);
}

void take_apart(std::span<const std::uint8_t> payload, Record& record) {
  assert(payload.size() >= kSealBytes);
  ByteReader seal(payload.last(kSealBytes));
  get_bytes(seal, record.seal.previous);
  record.seal.replaces = seal.get<std::uint32_t>();
  get_bytes(seal, record.seal.signature);
  const auto body = payload.first(payload.size() - kSealBytes);
  record.body.assign(body.begin(), body.end());
}

}  // namespace onemap::comms::wire
