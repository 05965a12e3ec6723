#pragma once
// A handshake of two robots with fixed keys: the same bytes in every run.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "comms/wire.hpp"
#include "session/half_open.hpp"
#include "session/initiation.hpp"

namespace onemap::comms::golden {

inline const TeamKey kTeam{{0x01, 0x02, 0x03, 0x04}};
inline constexpr Instant kNow{std::chrono::seconds(1)};

// As if random: bytes that count up from `first`.
inline RandomBytes counting_from(std::uint8_t first) {
  return [first](MutableBytes bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(first + i);
  };
}

// Robot `name` of life 7: its identity's seed is 32 bytes from `first` up, its static secret 32 from first + 0x20 up.
inline OwnSide side(const std::string& name, std::uint8_t first) {
  SecretSeed seed;
  counting_from(first)(seed);
  OwnSide own;
  counting_from(static_cast<std::uint8_t>(first + 0x20))(own.static_secret.bytes);
  own.static_public = noise::public_of(own.static_secret);
  own.greeting = signed_greeting(Identity(seed), own.static_public, RobotId::from_name(name), 7);
  return own;
}

inline std::vector<std::uint8_t> beacon() {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer;
  wire::Encoder out(buffer, {});
  out.beacon({RobotId::from_name("anna"), 0x1122334455667788, 0x99AABBCCDDEEFF00, 3, 1});
  return {buffer.begin() + wire::kHeaderBytes, buffer.begin() + static_cast<std::ptrdiff_t>(out.size())};
}

struct Talk {
  TeamSecrets team{kTeam};
  OwnSide anna = side("anna", 0x10), bert = side("bert", 0x80);
  Initiation initiation{kNow, 0xA1A2A3A4, anna, team, counting_from(0x50)};
  HalfOpen half{kNow, Endpoint::ipv4(10, 0, 0, 1, 4600), 0xB1B2B3B4, bert, team, counting_from(0xC0)};
  std::vector<std::uint8_t> hello, answer, proof;
  Greeting of_bert, of_anna;
  Talk() {
    const Bytes first = initiation.take(kNow, std::nullopt);
    hello.assign(first.begin(), first.end());
    EXPECT_TRUE(half.begin(hello, bert, team));
    answer.assign(half.answer().begin(), half.answer().end());
    EXPECT_EQ(initiation.read_answer(answer, of_bert), Refusal::count);
    EXPECT_TRUE(initiation.prove(kNow, answer, of_bert, anna, team));
    const Bytes third = initiation.take(kNow, std::nullopt);
    proof.assign(third.begin(), third.end());
    EXPECT_EQ(half.read_proof(proof, of_anna), Refusal::count);
  }
};

}  // namespace onemap::comms::golden
