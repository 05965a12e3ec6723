#include "records/voxel_coding.hpp"

#include <algorithm>

namespace onemap::mapping {

namespace {

// The nearest multiple; halves away from zero.
int steps_of(int value, int step) { return (value + (value < 0 ? -step : step) / 2) / step; }

int weight_step(int weight) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(kWeightSteps.size()); ++i)
    if (2 * weight >= kWeightSteps[static_cast<std::size_t>(i)] + kWeightSteps[static_cast<std::size_t>(i - 1)])
      best = i;
  return best;
}

// The nearest that is a colour.
int chroma_step(int value, int green) {
  int steps = steps_of(value - green, kChromaStep);
  while (green + kChromaStep * steps > 255) --steps;
  while (green + kChromaStep * steps < 0) ++steps;
  return steps;
}

bool has_channel(const VoxelSteps& voxel, VoxelChannel channel) {
  return channel >= kGreen ? voxel.colored : voxel.seen;
}

}  // namespace

VoxelSteps to_steps(const SubmapVoxel& voxel) {
  VoxelSteps out;
  out.seen = voxel.weight != 0;
  if (!out.seen) return out;
  out.value[kTsdf] = static_cast<std::int16_t>(steps_of(voxel.tsdf, kTsdfStep));
  out.value[kWeight] = static_cast<std::int16_t>(weight_step(voxel.weight));
  out.colored = voxel.rgb != Rgb{};
  if (!out.colored) return out;
  const int green = std::min(steps_of(voxel.rgb[1], kGreenStep), 255 / kGreenStep);
  out.value[kGreen] = static_cast<std::int16_t>(green);
  out.value[kRed] = static_cast<std::int16_t>(chroma_step(voxel.rgb[0], green * kGreenStep));
  out.value[kBlue] = static_cast<std::int16_t>(chroma_step(voxel.rgb[2], green * kGreenStep));
  // 0 0 0 would say that none was seen.
  if (out.value[kGreen] == 0 && out.value[kRed] == 0 && out.value[kBlue] == 0) out.value[kGreen] = 1;
  return out;
}

void VoxelPredictor::begin_block() { next_ = 0; }

const VoxelSteps* VoxelPredictor::back(int x, int y, int z, VoxelChannel channel) const {
  const int at_x = next_ % kBlockSide, at_y = next_ / kBlockSide % kBlockSide, at_z = next_ / (kBlockSide * kBlockSide);
  if (at_x < x || at_y < y || at_z < z) return nullptr;
  const int index = next_ - (z * kBlockSide + y) * kBlockSide - x;
  const VoxelSteps& voxel = block_[static_cast<std::size_t>(index)];
  return has_channel(voxel, channel) ? &voxel : nullptr;
}

// A channel is noisy: the mean of the neighbours. The distance is a plane's, too (what leads from one neighbour's
// corner to the other, Lorenzo), so it is halfway between that mean and the mean of the planes that are known: a plane
// alone has three neighbours' noise.
int VoxelPredictor::expected(VoxelChannel channel) const {
  const std::array<const VoxelSteps*, 3> near{back(1, 0, 0, channel), back(0, 1, 0, channel), back(0, 0, 1, channel)};
  int sum = 0, count = 0;
  for (const VoxelSteps* voxel : near)
    if (voxel != nullptr) sum += voxel->value[channel], ++count;
  if (channel == kTsdf) {
    const std::array<const VoxelSteps*, 3> corners{back(1, 1, 0, channel), back(1, 0, 1, channel),
                                                   back(0, 1, 1, channel)};
    constexpr std::array<std::array<std::size_t, 2>, 3> kSides{{{0, 1}, {0, 2}, {1, 2}}};
    int plane_sum = 0, planes = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (const auto* a = near[kSides[i][0]], *b = near[kSides[i][1]]; a && b && corners[i])
        plane_sum += a->value[channel] + b->value[channel] - corners[i]->value[channel], ++planes;
    if (planes > 0) return half_way(plane_sum, planes, sum, count);
  }
  return count == 0 ? last_[channel] : steps_of(sum, count);
}

void VoxelPredictor::set(const VoxelSteps& steps) {
  block_[static_cast<std::size_t>(next_++)] = steps;
  for (std::uint8_t channel = 0; channel < kVoxelChannels; ++channel)
    if (has_channel(steps, static_cast<VoxelChannel>(channel))) last_[channel] = steps.value[channel];
}

}  // namespace onemap::mapping
