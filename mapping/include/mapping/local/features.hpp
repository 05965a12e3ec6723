#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace onemap::mapping {

// A local feature of the grey image. Pixel centres at integers; sub-pixel position.
struct Keypoint {
  float x_px = 0, y_px = 0;
  float size_px = 0;                   // diameter of the region described (SURF: 20 s; ORB: patch size)
  float cos_angle = 1, sin_angle = 0;  // dominant orientation
  float response = 0;                  // detector's strength, larger is better
  std::int8_t laplacian = 0;  // SURF: sign of the Laplacian (bright blob on dark -1, dark on bright +1); ORB: 0
  bool operator==(const Keypoint&) const = default;
};

// 64 bytes that describe a feature. SURF: the 64 components as int8 (value * 127 rounded after normalisation to unit
// length and clamped to +-1), compared by squared Euclidean distance. ORB and surf_bits: 256 bits in the first 32
// bytes, the rest 0, compared by Hamming distance. Integers, so distances are equal on every machine.
struct alignas(32) Descriptor {
  std::array<std::int8_t, 64> v{};
  bool operator==(const Descriptor&) const = default;
};

// surf_bits: what a keyframe's record holds of SURF (descriptor_bits.hpp); no detector gives it.
enum class DescriptorKind : std::uint8_t { surf = 1, orb = 2, surf_bits = 3 };

inline bool is_binary(DescriptorKind kind) { return kind != DescriptorKind::surf; }

// The features of one image, strongest first; both vectors have the same length. reserve() once, no growth after.
struct FeatureSet {
  DescriptorKind kind = DescriptorKind::surf;
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
  void reserve(std::size_t capacity) {
    keypoints.reserve(capacity);
    descriptors.reserve(capacity);
  }
  void clear() {
    keypoints.clear();
    descriptors.clear();
  }
  std::size_t size() const { return keypoints.size(); }
};

// Feature a of the first set and b of the second belong together; distance as the descriptor kind measures it.
struct Match {
  std::uint16_t a = 0, b = 0;
  std::int32_t distance = 0;
  bool operator==(const Match&) const = default;
};

}  // namespace onemap::mapping
