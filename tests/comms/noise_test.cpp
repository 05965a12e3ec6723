#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "session/noise/handshake.hpp"
#include "support/hex.hpp"

namespace onemap::comms::noise {
namespace {

using nlohmann::json;
using test::array_from_hex;
using test::from_hex;
using test::to_hex;

// Every pattern of which there are vectors, as the specification has them (revision 34, 7.4, 7.5 and 18.1).
const std::map<std::string, Pattern>& patterns() {
  static const std::map<std::string, Pattern> all{
      {"N", pattern("e es", false, true)},
      {"K", pattern("e es ss", true, true)},
      {"X", pattern("e es s ss", false, true)},
      {"NN", pattern("e / e ee")},
      {"NK", pattern("e es / e ee", false, true)},
      {"NX", pattern("e / e ee s es")},
      {"XN", pattern("e / e ee / s se")},
      {"XK", pattern("e es / e ee / s se", false, true)},
      {"XX", pattern("e / e ee s es / s se")},
      {"KN", pattern("e / e ee se", true)},
      {"KK", pattern("e es ss / e ee se", true, true)},
      {"KX", pattern("e / e ee se s es", true)},
      {"IN", pattern("e s / e ee se")},
      {"IK", pattern("e es s ss / e ee se", false, true)},
      {"IX", pattern("e s / e ee se s es")},
      {"NK1", pattern("e / e ee es", false, true)},
      {"NX1", pattern("e / e ee s / es")},
      {"X1N", pattern("e / e ee / s / se")},
      {"X1K", pattern("e es / e ee / s / se", false, true)},
      {"XK1", pattern("e / e ee es / s se", false, true)},
      {"X1K1", pattern("e / e ee es / s / se", false, true)},
      {"X1X", pattern("e / e ee s es / s / se")},
      {"XX1", pattern("e / e ee s / es s se")},
      {"X1X1", pattern("e / e ee s / es s / se")},
      {"K1N", pattern("e / e ee / se", true)},
      {"K1K", pattern("e es / e ee / se", true, true)},
      {"KK1", pattern("e / e ee se es", true, true)},
      {"K1K1", pattern("e / e ee es / se", true, true)},
      {"K1X", pattern("e / e ee s es / se", true)},
      {"KX1", pattern("e / e ee se s / es", true)},
      {"K1X1", pattern("e / e ee s / se es", true)},
      {"I1N", pattern("e s / e ee / se")},
      {"I1K", pattern("e es s / e ee / se", false, true)},
      {"IK1", pattern("e s / e ee se es", false, true)},
      {"I1K1", pattern("e s / e ee es / se", false, true)},
      {"I1X", pattern("e s / e ee s es / se")},
      {"IX1", pattern("e s / e ee se s / es")},
      {"I1X1", pattern("e s / e ee s / se es")},
  };
  return all;
}

// psk0 goes before the first message's tokens, pskN behind those of message N.
Pattern with_psk(Pattern pattern, std::size_t place) {
  Message& message = pattern.messages[place == 0 ? 0 : place - 1];
  if (place == 0) {
    Message longer;
    longer.add(Token::psk);
    for (const Token token : message) longer.add(token);
    message = longer;
  } else {
    message.add(Token::psk);
  }
  pattern.with_psk = true;
  return pattern;
}

std::optional<Pattern> pattern_of(const std::string& protocol) {
  const std::string name = protocol.substr(6, protocol.find('_', 6) - 6);
  const std::size_t psk = name.find("psk");
  const auto base = patterns().find(name.substr(0, psk));
  if (base == patterns().end()) return std::nullopt;
  if (psk == std::string::npos) return base->second;
  return with_psk(base->second, static_cast<std::size_t>(name[psk + 3] - '0'));
}

Keys keys_of(const json& vector, const std::string& side) {
  const auto key = [&](const std::string& name) {
    return vector.contains(side + name) ? array_from_hex<32>(vector[side + name].get<std::string>())
                                        : std::array<std::uint8_t, 32>{};
  };
  Keys keys;
  keys.own_static = Key(key("_static"));
  keys.own_ephemeral = Key(key("_ephemeral"));
  keys.their_static = key("_remote_static");
  if (vector.contains(side + "_psks") && !vector[side + "_psks"].empty())
    keys.psk = Key(array_from_hex<32>(vector[side + "_psks"][0].get<std::string>()));
  return keys;
}

// What follows the handshake goes by turns; a one-way pattern's initiator goes on alone.
void check_transport(const json& vector, const Handshake& ended, std::size_t first, bool one_way) {
  const auto [from_initiator, from_responder] = ended.split();
  std::array<std::uint64_t, 2> counters{};
  for (std::size_t i = first; i < vector["messages"].size(); ++i) {
    const std::size_t side = one_way ? 0 : i % 2;
    const auto plain = from_hex(vector["messages"][i]["payload"].get<std::string>());
    std::vector<std::uint8_t> sealed(plain.size() + kTagBytes);
    seal(side == 0 ? from_initiator : from_responder, 0, counters[side]++, {}, plain, sealed);
    EXPECT_EQ(to_hex(sealed), vector["messages"][i]["ciphertext"].get<std::string>()) << "message " << i;
  }
}

void check(const json& vector, const Pattern& pattern) {
  const auto name = vector["protocol_name"].get<std::string>();
  SCOPED_TRACE(name);
  Handshake initiator(name, pattern, Role::initiator, from_hex(vector["init_prologue"].get<std::string>()),
                      keys_of(vector, "init"));
  Handshake responder(name, pattern, Role::responder, from_hex(vector["resp_prologue"].get<std::string>()),
                      keys_of(vector, "resp"));
  for (std::size_t i = 0; i < pattern.size; ++i) {
    Handshake& writer = i % 2 == 0 ? initiator : responder;
    Handshake& reader = i % 2 == 0 ? responder : initiator;
    const auto payload = from_hex(vector["messages"][i]["payload"].get<std::string>());
    std::vector<std::uint8_t> message(payload.size() + writer.overhead()), read(payload.size());
    ASSERT_TRUE(writer.write(payload, message));
    ASSERT_EQ(to_hex(message), vector["messages"][i]["ciphertext"].get<std::string>()) << "message " << i;
    ASSERT_TRUE(reader.read(message, read));
    ASSERT_EQ(read, payload);
  }
  ASSERT_TRUE(initiator.over() && responder.over());
  for (const Handshake* side : {&initiator, &responder})
    EXPECT_EQ(to_hex(side->hash()), vector["handshake_hash"].get<std::string>());
  check_transport(vector, responder, pattern.size, pattern.size == 1);
}

// From the public collection of the library cacophony, as far as it is of our suite.
const char* const kOurVector = R"({
"protocol_name": "Noise_XXpsk3_25519_ChaChaPoly_BLAKE2b",
"init_prologue": "4a6f686e2047616c74",
"init_psks": ["54686973206973206d7920417573747269616e20706572737065637469766521"],
"init_static": "e61ef9919cde45dd5f82166404bd08e38bceb5dfdfded0a34c8df7ed542214d1",
"init_ephemeral": "893e28b9dc6ca8d611ab664754b8ceb7bac5117349a4439a6b0569da977c464a",
"resp_prologue": "4a6f686e2047616c74",
"resp_psks": ["54686973206973206d7920417573747269616e20706572737065637469766521"],
"resp_static": "4a3acbfdb163dec651dfa3194dece676d437029c62a408b4c5ea9114246e4893",
"resp_ephemeral": "bbdb4cdbd309f1a1f2e1456967fe288cadd6f712d65dc7b7793d5e63da6b375b",
"handshake_hash": "46b5997dfa51492ae9be5b611748455e83aebdbc2ea3c47d264ec6dd408cc076e962ff056890c60398fe3e7a430bbe057f34383a84df9ff99391266dcfd638b0",
"messages": [
{"payload": "4c756477696720766f6e204d69736573",
 "ciphertext": "ca35def5ae56cec33dc2036731ab14896bc4c75dbb07a61f879f8e3afa4c79440aa831d1e3bbd16bd7ffda87e9f7b6eeca2510006499a573ac27af3392ed1b69"},
{"payload": "4d757272617920526f746862617264",
 "ciphertext": "95ebc60d2b1fa672c1f46a8aa265ef51bfe38e7ccb39ec5be34069f14480884381a78489d56c9e2ac962826f25684980b25244dbfd505b7d903a94d4f4fd84004a1c7fbe94d686bc4c1f67259364f6f2a41cb40bf5198b9b3975be2cdd49d3e065a554e12c477d82029fabc6555bc1"},
{"payload": "462e20412e20486179656b",
 "ciphertext": "291dfeff6eff386e29adb0bdbd5a1ae9e09de4449c8695d109adcb63e80e489555792a3e9150eff75d6d45571f824ed231173cb66e31e7da914241f86d0cbb678335ffe768a7445d2f5bc1"},
{"payload": "4361726c204d656e676572", "ciphertext": "6579dd60eb5e6a8b29dd60004289f5d3c2f69fcdbf683a869f59a8"},
{"payload": "4a65616e2d426170746973746520536179",
 "ciphertext": "24715fd39c3c7606e81b26e69e47b54d043d9d87c512f9417bae51ab48ebb17722"},
{"payload": "457567656e2042f6686d20766f6e2042617765726b",
 "ciphertext": "e49194a013d873712318643acbf0e3851086326bb168c500a766439ff543a7a1e2deb3215c"}]})";

TEST(Noise, OurPatternWritesThePublishedBytes) {
  const json vector = json::parse(kOurVector);
  EXPECT_EQ(vector["protocol_name"].get<std::string>(), kProtocolName);
  check(vector, kXXpsk3);
}

TEST(Noise, EveryPublishedVectorOfTheSuite) {
  const char* const elsewhere = std::getenv("ONEMAP_NOISE_VECTORS");
  const std::string file = elsewhere ? elsewhere : ONEMAP_SHARED_DIR "/data/noise/cacophony.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no vectors: " << file;
  std::ifstream in(file);
  const json all = json::parse(in);
  std::size_t ran = 0;
  for (const json& vector : all["vectors"]) {
    const auto name = vector["protocol_name"].get<std::string>();
    if (!name.ends_with("_25519_ChaChaPoly_BLAKE2b")) continue;
    const auto pattern = pattern_of(name);
    if (!pattern) {
      ADD_FAILURE() << "no table for " << name;
      continue;
    }
    check(vector, *pattern);
    ++ran;
  }
  EXPECT_GE(ran, 59u);
  RecordProperty("vectors", static_cast<int>(ran));
}

struct Pair {
  Handshake initiator, responder;
};
Pair pair_with(const Key& psk_of_initiator, const Key& psk_of_responder) {
  Keys first, second;
  first.own_static = Key({1, 2, 3});
  first.own_ephemeral = Key({4, 5, 6});
  second.own_static = Key({7, 8, 9});
  second.own_ephemeral = Key({10, 11, 12});
  first.psk = psk_of_initiator;
  second.psk = psk_of_responder;
  return {Handshake(kProtocolName, kXXpsk3, Role::initiator, {}, first),
          Handshake(kProtocolName, kXXpsk3, Role::responder, {}, second)};
}
// Lets the sides talk, with each message changed by `spoil`: how many messages were taken.
std::size_t messages_taken(Pair sides, const std::function<void(std::size_t, std::vector<std::uint8_t>&)>& spoil) {
  for (std::size_t i = 0; i < kXXpsk3.size; ++i) {
    Handshake& writer = i % 2 == 0 ? sides.initiator : sides.responder;
    Handshake& reader = i % 2 == 0 ? sides.responder : sides.initiator;
    const std::vector<std::uint8_t> payload(20, 5);
    std::vector<std::uint8_t> message(payload.size() + writer.overhead()), read(payload.size());
    if (!writer.write(payload, message)) return i;
    spoil(i, message);
    if (!reader.read(message, read)) return i;
  }
  return kXXpsk3.size;
}

TEST(Noise, AnotherTeamKeyEndsInTheThirdMessage) {
  const auto leave = [](std::size_t, auto&) {};
  EXPECT_EQ(messages_taken(pair_with(Key({1}), Key({1})), leave), 3u);
  EXPECT_EQ(messages_taken(pair_with(Key({1}), Key({2})), leave), 2u);
}

// The first message's key is only what is public; from the second on every bit counts.
TEST(Noise, AnyBitThatChangedIsSeen) {
  for (std::size_t message = 0; message < 3; ++message) {
    for (std::size_t bit = 0; bit < 8 * 52; bit += 5) {
      const auto flip = [&](std::size_t i, std::vector<std::uint8_t>& bytes) {
        if (i == message) bytes[(bit / 8) % bytes.size()] ^= static_cast<std::uint8_t>(1u << (bit % 8));
      };
      EXPECT_LT(messages_taken(pair_with(Key({1}), Key({1})), flip), 3u) << message << " " << bit;
    }
  }
}

TEST(Noise, APointOfLowOrderIsRefused) {
  const auto zeros = [](std::size_t i, std::vector<std::uint8_t>& bytes) {
    if (i == 1) std::fill_n(bytes.begin(), 32, std::uint8_t{0});
  };
  EXPECT_EQ(messages_taken(pair_with(Key({1}), Key({1})), zeros), 1u);
}

TEST(Noise, AMessageOfAnotherLengthIsRefused) {
  Pair sides = pair_with(Key({1}), Key({1}));
  std::vector<std::uint8_t> message(sides.initiator.overhead());
  ASSERT_TRUE(sides.initiator.write({}, message));
  std::array<std::uint8_t, 1> payload{};
  EXPECT_FALSE(sides.responder.read(message, payload));
  EXPECT_FALSE(sides.responder.read(Bytes(message).first(47), {}));
  EXPECT_TRUE(sides.responder.read(message, {})) << "and nothing was done with those";
}

}  // namespace
}  // namespace onemap::comms::noise
