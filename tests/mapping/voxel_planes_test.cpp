// The fast decoder of a submap's voxels beside a slow and plain one that asks VoxelPredictor for every voxel.
#include "records/voxel_planes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "support/random.hpp"

namespace onemap::mapping {
namespace {

struct Planes {
  std::size_t blocks = 0;
  std::vector<std::uint8_t> seen, colored;
  std::array<std::vector<std::uint8_t>, kVoxelChannels> channels;

  VoxelPlanes spans() const {
    VoxelPlanes out{seen, colored, {}};
    for (std::size_t c = 0; c < kVoxelChannels; ++c) out.channels[c] = channels[c];
    return out;
  }
};

bool bit(const std::vector<std::uint8_t>& mask, std::size_t i) { return ((mask[i / 8] >> (i % 8)) & 1) != 0; }
void append(std::vector<std::uint8_t>& mask, std::size_t i, bool value) {
  if (i % 8 == 0) mask.push_back(0);
  mask.back() = static_cast<std::uint8_t>(mask.back() | (value ? 1u << (i % 8) : 0u));
}
bool is_byte(int value) { return value >= 0 && value <= 255; }

// The voxel with these steps, if there is one.
std::optional<SubmapVoxel> voxel_of(const VoxelSteps& steps) {
  SubmapVoxel out;
  if (!steps.seen) return out;
  const int tsdf = steps.value[kTsdf], weight = steps.value[kWeight];
  const int farthest = to_steps({kTsdfOne, 1, {}}).value[kTsdf];
  if (tsdf < -farthest || tsdf > farthest) return std::nullopt;
  if (weight < 0 || weight >= static_cast<int>(kWeightSteps.size())) return std::nullopt;
  out.tsdf = static_cast<std::int16_t>(std::clamp(kTsdfStep * tsdf, -kTsdfOne, kTsdfOne));
  out.weight = kWeightSteps[static_cast<std::size_t>(weight)];
  if (!steps.colored) return out;
  const int green = kGreenStep * steps.value[kGreen], red = green + kChromaStep * steps.value[kRed],
            blue = green + kChromaStep * steps.value[kBlue];
  if (!is_byte(green) || !is_byte(red) || !is_byte(blue) || (green | red | blue) == 0) return std::nullopt;
  out.rgb = {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green), static_cast<std::uint8_t>(blue)};
  return out;
}

std::optional<std::vector<SubmapVoxel>> decode_slowly(const Planes& planes) {
  std::vector<SubmapVoxel> out;
  VoxelPredictor predictor;
  std::size_t observed = 0, colors = 0;
  for (std::size_t i = 0; i < planes.blocks * kBlockVoxels; ++i) {
    if (i % kBlockVoxels == 0) predictor.begin_block();
    VoxelSteps steps;
    steps.seen = bit(planes.seen, i);
    steps.colored = steps.seen && bit(planes.colored, observed);
    for (const VoxelChannel c : {kTsdf, kWeight, kGreen, kRed, kBlue}) {
      if (!(c >= kGreen ? steps.colored : steps.seen)) break;
      const std::uint8_t change = planes.channels[c][c >= kGreen ? colors : observed];
      steps.value[c] = static_cast<std::int8_t>(static_cast<std::uint8_t>(predictor.expected(c) + change));
    }
    observed += steps.seen ? 1 : 0;
    colors += steps.colored ? 1 : 0;
    const auto voxel = voxel_of(steps);
    if (!voxel) return std::nullopt;
    out.push_back(*voxel);
    predictor.set(steps);
  }
  return out;
}

std::optional<std::vector<SubmapVoxel>> decode_fast(const Planes& planes) {
  std::vector<SubmapBlock> blocks(planes.blocks);
  if (!decode_voxels(planes.spans(), blocks)) return std::nullopt;
  std::vector<SubmapVoxel> out;
  for (const SubmapBlock& block : blocks) out.insert(out.end(), block.voxels.begin(), block.voxels.end());
  return out;
}

bool equal(const SubmapVoxel& a, const SubmapVoxel& b) {
  return a.tsdf == b.tsdf && a.weight == b.weight && a.rgb == b.rgb;
}

// Equal voxels, or both refuse; true when both accept.
bool expect_equal(const Planes& planes) {
  const auto slow = decode_slowly(planes), fast = decode_fast(planes);
  EXPECT_EQ(fast.has_value(), slow.has_value());
  if (!slow || !fast) return false;
  EXPECT_TRUE(std::ranges::equal(*fast, *slow, equal));
  return true;
}

// Three blocks; of every `one_in` voxels about all but one are seen, and of these coloured.
Planes encode(test::Random& random, std::uint64_t one_in, bool smooth) {
  Planes out;
  out.blocks = 3;
  VoxelPredictor predictor;
  std::size_t observed = 0;
  for (std::size_t i = 0; i < out.blocks * kBlockVoxels; ++i) {
    if (i % kBlockVoxels == 0) predictor.begin_block();
    SubmapVoxel voxel;
    if (random.next() % one_in != 0) {
      const int along = static_cast<int>(i % 8 * 40 + i / 8 % 8 * 70);
      voxel.tsdf = static_cast<std::int16_t>(smooth ? along - 400 : static_cast<int>(random.next() % 2001) - 1000);
      voxel.weight = static_cast<std::uint8_t>(1 + random.next() % 255);
      if (random.next() % one_in != 0)
        for (std::uint8_t& c : voxel.rgb) c = static_cast<std::uint8_t>(random.next() % 256);
    }
    const VoxelSteps steps = to_steps(voxel);
    append(out.seen, i, steps.seen);
    if (steps.seen) append(out.colored, observed++, steps.colored);
    for (const VoxelChannel c : {kTsdf, kWeight, kGreen, kRed, kBlue})
      if (c >= kGreen ? steps.colored : steps.seen)
        out.channels[c].push_back(static_cast<std::uint8_t>(steps.value[c] - predictor.expected(c)));
    predictor.set(steps);
  }
  return out;
}

TEST(VoxelPlanes, AreDecodedAsTheSlowDecoderDoes) {
  test::Random random(21);
  for (const std::uint64_t one_in : {1, 2, 3, 10, 1000})
    for (const bool smooth : {false, true})
      for (int i = 0; i < 20; ++i) EXPECT_TRUE(expect_equal(encode(random, one_in, smooth)));
}

// One byte is another: most such planes are refused, and the others say something else, in both decoders alike.
TEST(VoxelPlanes, AreRefusedWhereTheSlowDecoderRefuses) {
  test::Random random(22);
  int accepted = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Planes planes = encode(random, 4, i % 2 == 0);
    auto& channel = planes.channels[random.next() % kVoxelChannels];
    // Early ones are seldom harmless, so half of them are among the last.
    const std::size_t at = channel.size() - 1 - random.next() % (i % 4 < 2 ? channel.size() : 8);
    channel[at] = static_cast<std::uint8_t>(random.next());
    ++(expect_equal(planes) ? accepted : refused);
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace onemap::mapping
