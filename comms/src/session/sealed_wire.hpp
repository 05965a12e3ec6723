#pragma once
#include <cstddef>
#include <cstdint>

#include "comms/counters.hpp"
#include "comms/datagram_port.hpp"
#include "comms/secret.hpp"

// Datagrams of major version 2 (comms/PROTOCOL.md): what a team with a key puts on the network.
namespace onemap::comms::sealed {

inline constexpr std::uint8_t kMagicAndVersion = 0xB2;
enum class Type : std::uint8_t { hello = 1, answer = 2, proof = 3, cookie = 4, frames = 5, own = 6, group = 9 };

inline constexpr std::size_t kHeadBytes = 4;  // magic and version, type, two zeros
inline constexpr std::size_t kTagBytes = 16, kMacBytes = 16, kGreetingBytes = 120;

// hello: head, sender's index, Noise's first message, mac1, mac2, padding.
inline constexpr std::size_t kHelloNoiseAt = 8, kHelloNoiseBytes = 48, kHelloMac1At = 56, kHelloMac2At = 72;
inline constexpr std::size_t kHelloUsedBytes = 88, kHelloBytes = kMaxDatagramBytes;
// answer and proof: head, sender's index, receiver's index, Noise's message, mac1.
inline constexpr std::size_t kNoiseAt = 12;
inline constexpr std::size_t kAnswerNoiseBytes = 32 + 48 + kGreetingBytes + kTagBytes;
inline constexpr std::size_t kAnswerBytes = kNoiseAt + kAnswerNoiseBytes + kMacBytes;
inline constexpr std::size_t kProofNoiseBytes = 48 + kGreetingBytes + kTagBytes;
inline constexpr std::size_t kProofBytes = kNoiseAt + kProofNoiseBytes + kMacBytes;
// cookie: head, receiver's index, nonce, sealed cookie.
inline constexpr std::size_t kCookieNonceAt = 8, kCookieSealedAt = 32, kCookieBytes = 64;
// frames and own: head, receiver's index, counter, sealed. The head, index and counter are the associated data.
inline constexpr std::size_t kHeaderBytes = 16, kOverheadBytes = kHeaderBytes + kTagBytes;
inline constexpr std::size_t kOwnPlainBytes = 9, kOwnBytes = kOverheadBytes + kOwnPlainBytes;
// group: head, nonce, sealed(incarnation, counter, frames).
inline constexpr std::size_t kGroupNonceAt = 4, kGroupSealedAt = 28, kGroupPlainHeadBytes = 16;
inline constexpr std::size_t kGroupOverheadBytes = kGroupSealedAt + kGroupPlainHeadBytes + kTagBytes;

// What a datagram of type `own` says: a byte, and a token.
enum class Word : std::uint8_t { here = 0, probe = 1, probe_answer = 2 };

// Looks at size, magic, version, type and zeros: Refusal::count when they are good.
Refusal read_head(Bytes datagram, Type& type);
void write_head(MutableBytes datagram, Type type);
std::uint32_t index_at(Bytes datagram, std::size_t at);
std::uint64_t counter_of(Bytes datagram);

}  // namespace onemap::comms::sealed
