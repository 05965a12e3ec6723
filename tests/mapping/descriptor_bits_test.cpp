#include "mapping/local/descriptor_bits.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.hpp"

namespace onemap::mapping {
namespace {

using test::Random;

// Unit length as int8, like SURF's.
Descriptor random_descriptor(Random& random) {
  std::array<double, 64> v{};
  double length2 = 0;
  for (double& c : v) c = random.uniform(-1, 1), length2 += c * c;
  Descriptor out;
  for (std::size_t i = 0; i < 64; ++i)
    out.v[i] = static_cast<std::int8_t>(std::lround(v[i] * 127 / std::sqrt(length2)));
  return out;
}

Descriptor mixed(const Descriptor& a, const Descriptor& b, double share) {
  Descriptor out;
  for (std::size_t i = 0; i < 64; ++i)
    out.v[i] = static_cast<std::int8_t>(std::lround((1 - share) * a.v[i] + share * b.v[i]));
  return out;
}

// Robots compare each other's bits: they must be the same on every machine and in every version. The numbers are those
// of another implementation, from the same definition.
TEST(DescriptorBits, AreThePinnedOnes) {
  Descriptor d;
  for (std::size_t i = 0; i < 64; ++i) d.v[i] = static_cast<std::int8_t>(static_cast<int>(i * 37 % 61) - 30);
  const DescriptorBits bits = to_bits(d, DescriptorKind::surf);
  EXPECT_EQ(bits, (DescriptorBits{0x7d446ade0d232ffau, 0x9bf68956c331bcebu, 0x2a9b9f1fe355d4feu, 0x58c531460209d5b0u}))
      << std::hex << bits[0] << " " << bits[1] << " " << bits[2] << " " << bits[3];
}

TEST(DescriptorBits, DifferTheMoreTheLessAlikeTheDescriptorsAre) {
  Random random(3);
  std::array<double, 5> mean{};
  for (int i = 0; i < 300; ++i) {
    const Descriptor a = random_descriptor(random), b = random_descriptor(random);
    for (std::size_t k = 0; k < mean.size(); ++k) {
      const Descriptor c = mixed(a, b, 0.25 * static_cast<double>(k));
      mean[k] += hamming_distance(to_bits(a, DescriptorKind::surf), to_bits(c, DescriptorKind::surf)) / 300.0;
    }
  }
  EXPECT_EQ(mean[0], 0);
  for (std::size_t k = 1; k < mean.size(); ++k) EXPECT_GT(mean[k], mean[k - 1] + 10);
  EXPECT_LT(mean[1], 48) << "alike, as the place index has it";
  EXPECT_GT(mean[4], 80) << "strangers; the common mean keeps them below 128";
}

TEST(DescriptorBits, EachBitIsNowSetAndNowNot) {
  Random random(4);
  std::array<int, 256> set{};
  for (int i = 0; i < 1000; ++i) {
    Descriptor d;  // about the mean descriptor, roughly: |dx| and |dy| are positive
    for (std::size_t c = 0; c < 64; ++c)
      d.v[c] = static_cast<std::int8_t>(random.integer(-25, 25) + (c % 2 == 1 ? 17 : 0));
    const DescriptorBits bits = to_bits(d, DescriptorKind::surf);
    for (std::size_t b = 0; b < 256; ++b) set[b] += static_cast<int>((bits[b / 64] >> (b % 64)) & 1);
  }
  for (const int n : set) {
    EXPECT_GT(n, 50);
    EXPECT_LT(n, 950);
  }
}

TEST(DescriptorBits, OrbKeepsItsOwn) {
  Random random(5);
  Descriptor d;
  for (std::size_t i = 0; i < 32; ++i) d.v[i] = static_cast<std::int8_t>(random.integer(-128, 127));
  EXPECT_EQ(from_bits(to_bits(d, DescriptorKind::orb)), d);
  EXPECT_EQ(to_bits(d, DescriptorKind::orb)[0] & 0xFF, static_cast<std::uint8_t>(d.v[0]));
  EXPECT_EQ(kind_of_bits(DescriptorKind::orb), DescriptorKind::orb);
  EXPECT_EQ(kind_of_bits(DescriptorKind::surf), DescriptorKind::surf_bits);
}

}  // namespace
}  // namespace onemap::mapping
