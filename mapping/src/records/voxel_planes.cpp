#include "records/voxel_planes.hpp"

#include <algorithm>
#include <bit>

namespace onemap::mapping {
namespace {

// One block's steps behind a border without any, so that neighbours need no test whether they are in the block.
constexpr int kSide = kBlockSide + 1;
constexpr int kBefore[3] = {1, kSide, kSide* kSide};  // to the neighbours on the three axes
constexpr int kPadded = kSide * kSide * kSide;

constexpr int kLargestSum = 3 * 128;
// Sums of one to three steps divided by how many they are, halves away from zero.
constexpr auto kMeans = [] {
  std::array<std::array<std::int16_t, 2 * kLargestSum + 1>, 4> out{};
  for (int count = 1; count <= 3; ++count)
    for (int sum = -128 * count; sum <= 127 * count; ++sum)
      out[static_cast<std::size_t>(count)][static_cast<std::size_t>(sum + kLargestSum)] =
          static_cast<std::int16_t>((sum + (sum < 0 ? -count : count) / 2) / count);
  return out;
}();

// The factor of half_way(), by the number of planes and of neighbours.
constexpr auto kHalfWay = [] {
  std::array<std::array<int, 4>, 4> out{};
  for (int planes = 1; planes <= 3; ++planes)
    for (int near = 2; near <= 3; ++near)
      out[static_cast<std::size_t>(planes)][static_cast<std::size_t>(near)] =
          (65536 + planes * near) / (2 * planes * near);
  return out;
}();

// A byte is a change modulo 256.
std::int16_t changed(int expected, std::uint8_t change) {
  return static_cast<std::int16_t>(static_cast<std::int8_t>(expected + change));
}

class Decoder {
 public:
  explicit Decoder(const VoxelPlanes& planes) : colored_plane_(planes.colored.data()) {
    for (std::size_t c = 0; c < kVoxelChannels; ++c) changes_[c] = planes.channels[c].data();
  }

  bool block(const std::uint8_t* seen, SubmapBlock& out) {
    at_ = {};
    SubmapVoxel* voxels = out.voxels.data();
    for (int z = 0; z < kBlockSide; ++z)
      for (int y = 0; y < kBlockSide; ++y, voxels += kBlockSide)
        row(*seen++, ((z + 1) * kSide + y + 1) * kSide + 1, voxels);
    return good_;
  }

 private:
  void row(unsigned seen, int first, SubmapVoxel* out) {
    for (; seen != 0; seen &= seen - 1) {
      const int x = std::countr_zero(seen);
      voxel(static_cast<std::size_t>(first + x), out[x]);
    }
  }

  void voxel(std::size_t at, SubmapVoxel& out) {
    const int near = present(at_.seen, at);
    const int tsdf = read<kTsdf>(at, observed_, expected_distance(at, near));
    const int weight = read<kWeight>(at, observed_, expected<kWeight>(at, near));
    at_.seen[at] = 1;
    good_ =
        good_ & (tsdf >= -kLargestDistance) & (tsdf <= kLargestDistance) & (static_cast<unsigned>(weight) < kWeights);
    out.tsdf = static_cast<std::int16_t>(std::clamp(tsdf * kTsdfStep, -kTsdfOne, kTsdfOne));
    out.weight = kWeightSteps[static_cast<unsigned>(weight) < kWeights ? static_cast<std::size_t>(weight) : 0];
    const bool colored = ((colored_plane_[observed_ / 8] >> (observed_ % 8)) & 1) != 0;
    ++observed_;
    if (colored) color(at, out);
  }

  void color(std::size_t at, SubmapVoxel& out) {
    const int near = present(at_.colored, at);
    const int green = read<kGreen>(at, colors_, expected<kGreen>(at, near)) * kGreenStep;
    const int red = green + read<kRed>(at, colors_, expected<kRed>(at, near)) * kChromaStep;
    const int blue = green + read<kBlue>(at, colors_, expected<kBlue>(at, near)) * kChromaStep;
    at_.colored[at] = 1;
    ++colors_;
    // Negative ones have their high bits set; 0 0 0 would say that no colour was seen.
    const int any = red | green | blue;
    good_ = good_ & (any > 0) & (any <= 255);
    out.rgb = {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green), static_cast<std::uint8_t>(blue)};
  }

  template <VoxelChannel channel>
  int read(std::size_t at, std::size_t n, int expected) {
    const std::int16_t value = changed(expected, changes_[channel][n]);
    at_.steps[channel][at] = static_cast<std::int8_t>(value);
    last_[channel] = value;
    return value;
  }

  using Flags = std::array<std::uint8_t, kPadded>;
  static int present(const Flags& flags, std::size_t at) {
    return flags[at - kBefore[0]] + flags[at - kBefore[1]] + flags[at - kBefore[2]];
  }
  template <VoxelChannel channel>
  int expected(std::size_t at, int near) const {
    const auto& steps = at_.steps[channel];
    const int sum = steps[at - kBefore[0]] + steps[at - kBefore[1]] + steps[at - kBefore[2]];
    const int mean = kMeans[static_cast<std::size_t>(near)][static_cast<std::size_t>(sum + kLargestSum)];
    return near == 0 ? last_[channel] : mean;
  }
  // Of two axes: the neighbours on them, and what is before both, lie on a plane with this voxel. Steps that were not
  // seen are 0.
  template <int a, int b>
  void add_plane(std::size_t at, int& sum, int& planes) const {
    const auto& steps = at_.steps[kTsdf];
    const std::size_t first = at - kBefore[a], second = at - kBefore[b], corner = first - kBefore[b];
    const int known = at_.seen[first] & at_.seen[second] & at_.seen[corner];
    planes += known;
    sum += known * (steps[first] + steps[second] - steps[corner]);
  }
  int expected_distance(std::size_t at, int near) const {
    int plane_sum = 0, planes = 0;
    add_plane<0, 1>(at, plane_sum, planes);
    add_plane<0, 2>(at, plane_sum, planes);
    add_plane<1, 2>(at, plane_sum, planes);
    if (planes == 0) return expected<kTsdf>(at, near);
    const auto& steps = at_.steps[kTsdf];
    const int sum = steps[at - kBefore[0]] + steps[at - kBefore[1]] + steps[at - kBefore[2]];
    const int factor = kHalfWay[static_cast<std::size_t>(planes)][static_cast<std::size_t>(near)];
    return ((plane_sum * near + sum * planes) * factor + 32768) >> 16;
  }

  static constexpr int kLargestDistance = (kTsdfOne + kTsdfStep / 2) / kTsdfStep;
  static constexpr unsigned kWeights = kWeightSteps.size();

  const std::uint8_t* colored_plane_;
  std::array<const std::uint8_t*, kVoxelChannels> changes_{};
  std::size_t observed_ = 0, colors_ = 0;  // so far
  bool good_ = true;
  std::array<int, kVoxelChannels> last_{};  // of the voxel before that had the channel, in any block
  struct {
    Flags seen, colored;
    std::array<std::array<std::int8_t, kPadded>, kVoxelChannels> steps;
  } at_{};  // of the block
};

}  // namespace

bool decode_voxels(const VoxelPlanes& planes, std::span<SubmapBlock> blocks) {
  Decoder decoder(planes);
  const std::uint8_t* seen = planes.seen.data();
  for (SubmapBlock& block : blocks) {
    if (!decoder.block(seen, block)) return false;
    seen += kBlockVoxels / 8;
  }
  return true;
}

}  // namespace onemap::mapping
