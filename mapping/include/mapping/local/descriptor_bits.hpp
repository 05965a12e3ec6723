#pragma once
#include <array>
#include <bit>
#include <cstdint>

#include "mapping/local/features.hpp"

namespace onemap::mapping {

// 256 bits that describe a feature, in four words; compared by Hamming distance.
using DescriptorBits = std::array<std::uint64_t, 4>;

// The bits of a descriptor of this kind. SURF: the signs of the components after four fixed rotations about the mean
// descriptor, which keep 99.8 % of the links that the 64 components find, in half the bytes. ORB and surf_bits: its own
// 256. Integer sums, so the bits are equal on every machine. kind_of_bits says what they are then.
DescriptorBits to_bits(const Descriptor& descriptor, DescriptorKind kind);
constexpr DescriptorKind kind_of_bits(DescriptorKind kind) {
  return kind == DescriptorKind::surf ? DescriptorKind::surf_bits : kind;
}

// The bits in a descriptor's first 32 bytes, for a FeatureSet of such a kind.
Descriptor from_bits(const DescriptorBits& bits);

[[gnu::always_inline]] inline std::int32_t hamming_distance(const DescriptorBits& a, const DescriptorBits& b) {
  return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
         std::popcount(a[3] ^ b[3]);
}

}  // namespace onemap::mapping
