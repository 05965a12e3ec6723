#include "comms/identity.hpp"

#include <gtest/gtest.h>

#include <charconv>

namespace onemap::comms {
namespace {

template <std::size_t N>
std::array<std::uint8_t, N> from_hex(std::string_view text) {
  std::array<std::uint8_t, N> bytes{};
  for (std::size_t i = 0; i < N; ++i) std::from_chars(&text[2 * i], &text[2 * i] + 2, bytes[i], 16);
  return bytes;
}

TEST(Identity, SignsAsRfc8032DoesInItsSecondTest) {
  const Identity identity(from_hex<32>("4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb"));
  EXPECT_EQ(identity.public_key(), (from_hex<32>("3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c")));
  const std::array<std::uint8_t, 1> message{0x72};
  EXPECT_EQ(identity.sign(message), (from_hex<64>("92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da"
                                                  "085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00")));
}

TEST(Identity, AnyBitThatChangedIsSeen) {
  const Identity identity(SecretSeed{7});
  std::vector<std::uint8_t> message(100, 5);
  const Signature good = identity.sign(message);
  EXPECT_TRUE(verify(identity.public_key(), message, good));
  for (std::size_t bit = 0; bit < 8 * good.size(); bit += 7) {
    Signature bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    EXPECT_FALSE(verify(identity.public_key(), message, bad)) << bit;
  }
  for (std::size_t i = 0; i < message.size(); i += 9) {
    message[i] ^= 1;
    EXPECT_FALSE(verify(identity.public_key(), message, good)) << i;
    message[i] ^= 1;
  }
  EXPECT_FALSE(verify(Identity(SecretSeed{8}).public_key(), message, good));
  EXPECT_FALSE(verify(PublicKey{}, message, good));
}

}  // namespace
}  // namespace onemap::comms
