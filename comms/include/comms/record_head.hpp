#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "comms/identity.hpp"
#include "hal/base/record.hpp"

namespace onemap::comms {

using Hash = std::array<std::uint8_t, 32>;  // BLAKE2b-256

// What is signed of a record: all of it, with the digest of its body in the body's place, so that it can be checked
// when the body is gone. Each head names the hash of the one before it, so a log is a chain that nobody, its author
// included, can change later without being seen. The first head of a log names its author's public key instead.
struct RecordHead {
  RecordId id;
  std::uint16_t kind = 0;
  std::uint32_t bytes = 0;  // of the body
  Hash body{};              // its digest
  Hash previous{};
  std::uint32_t replaces = kNoSequence;  // an earlier record of the log and kind
};
struct SignedHead {
  RecordHead head;
  Signature signature{};
};
inline constexpr std::size_t kSignedHeadBytes = 119;  // as it is signed (comms/PROTOCOL.md)
inline constexpr std::size_t kSealBytes = 100;        // previous 32, replaces 4, signature 64: what travels with a body

Hash digest_of(std::span<const std::uint8_t> bytes);
RecordHead head_of(const Record& record);  // digests the body, if it is there
std::array<std::uint8_t, kSignedHeadBytes> signed_bytes(const RecordHead& head);
Hash hash_of(const RecordHead& head);  // of its signed bytes; a signature is no part of it

// The same record without its body: head and seal are what they were.
Record without_body(const Record& record);

// Makes the record its author's: `previous` is the hash of the head before it. A log's first record: nothing is asked
// of it, the key takes its place. Answers the hash of this head.
Hash seal(Record& record, const Hash& previous, const Identity& author);
bool signed_by(const PublicKey& key, const RecordHead& head, const Signature& signature);

}  // namespace onemap::comms
