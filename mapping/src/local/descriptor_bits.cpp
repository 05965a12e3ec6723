#include "mapping/local/descriptor_bits.hpp"

#include "hal/base/splitmix.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kSize = 64;
using Components = std::array<std::int32_t, kSize>;

// The mean descriptor, over two recordings of a desk and two simulated rooms, each of which is within 4 of it; the
// sums of |dx| and |dy| are never negative.
constexpr std::array<std::int8_t, kSize> kMeans{
    0,  9,  -1, 8,  5,  19, -2, 14, 5,  18, 1,  13, 0,  8,  1,  8,   //
    -2, 15, -1, 13, 11, 36, -3, 23, 11, 33, 1,  21, -1, 13, 1,  11,  //
    -2, 15, 1,  13, 11, 36, 3,  23, 11, 33, -1, 21, -1, 13, -1, 11,  //
    0,  9,  2,  8,  5,  18, 2,  13, 5,  18, -1, 13, 0,  8,  -1, 8,   //
};

// A rotation: three times signs by chance, then the Walsh-Hadamard transform, which is orthonormal but for its scale
// (Andoni and others 2015: as good as a random rotation, and nothing to store).
constexpr std::size_t kRotations = 4, kRounds = 3;

constexpr std::array<std::array<Components, kRounds>, kRotations> make_signs() {
  std::array<std::array<Components, kRounds>, kRotations> out{};
  SplitMix random(7);
  for (auto& rotation : out)
    for (Components& signs : rotation) {
      const std::uint64_t word = random.next();
      for (std::size_t i = 0; i < kSize; ++i) signs[i] = ((word >> i) & 1) != 0 ? -1 : 1;
    }
  return out;
}
constexpr auto kSigns = make_signs();

// The length grows eightfold each time: from at most 8 x 254 to 2^20, so 32 bits are enough.
void transform(Components& x) {
  for (std::size_t half = 1; half < kSize; half *= 2)
    for (std::size_t block = 0; block < kSize; block += 2 * half)
      for (std::size_t i = block; i < block + half; ++i) {
        const std::int32_t a = x[i], b = x[i + half];
        x[i] = a + b;
        x[i + half] = a - b;
      }
}

std::uint64_t positive(const Components& x) {
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < kSize; ++i) word |= static_cast<std::uint64_t>(x[i] > 0) << i;
  return word;
}

DescriptorBits surf_bits(const Descriptor& descriptor) {
  DescriptorBits out{};
  for (std::size_t r = 0; r < kRotations; ++r) {
    Components x{};
    for (std::size_t i = 0; i < kSize; ++i) x[i] = descriptor.v[i] - kMeans[i];
    for (const Components& signs : kSigns[r]) {
      for (std::size_t i = 0; i < kSize; ++i) x[i] *= signs[i];
      transform(x);
    }
    out[r] = positive(x);
  }
  return out;
}

DescriptorBits own_bits(const Descriptor& descriptor) {
  DescriptorBits out{};
  for (std::size_t i = 0; i < 32; ++i)
    out[i / 8] |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(descriptor.v[i])) << (8 * (i % 8));
  return out;
}

}  // namespace

DescriptorBits to_bits(const Descriptor& descriptor, DescriptorKind kind) {
  return kind == DescriptorKind::surf ? surf_bits(descriptor) : own_bits(descriptor);
}

Descriptor from_bits(const DescriptorBits& bits) {
  Descriptor out;
  for (std::size_t i = 0; i < 32; ++i) out.v[i] = static_cast<std::int8_t>(bits[i / 8] >> (8 * (i % 8)));
  return out;
}

}  // namespace onemap::mapping
