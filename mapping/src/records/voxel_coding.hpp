#pragma once
#include <array>
#include <cstdint>

#include "mapping/records/submap.hpp"

// How a submap's voxels stand on the wire: as steps, each as its change from what its neighbours in the block let
// expect, so that what is smooth becomes small numbers.
namespace onemap::mapping {

// Half a step is the largest error: 0.8 % of the truncation (0.5 mm of 6 cm), a fifth of a weight, 2 of 255 in green
// and 6 in red and blue (which are steps of their distance to green).
inline constexpr int kTsdfStep = 16, kGreenStep = 4, kChromaStep = 8;
inline constexpr std::array<std::uint8_t, 16> kWeightSteps{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 255};

enum VoxelChannel : std::uint8_t { kTsdf, kWeight, kGreen, kRed, kBlue, kVoxelChannels };  // red, blue: minus green

struct VoxelSteps {
  std::array<std::int16_t, kVoxelChannels> value{};
  bool seen = false, colored = false;
};
VoxelSteps to_steps(const SubmapVoxel& voxel);  // the nearest

// The steps of one block's voxels in order, x fastest, and what is expected of the next one's. Says plainly what
// decode_voxels() (voxel_planes.hpp) does fast.
class VoxelPredictor {
 public:
  void begin_block();
  // expected(), then set(), for each voxel; channels of what was not seen are not asked for.
  int expected(VoxelChannel channel) const;
  void set(const VoxelSteps& steps);

 private:
  const VoxelSteps* back(int x, int y, int z, VoxelChannel channel) const;  // nullptr: not in the block, or not seen

  std::array<VoxelSteps, kBlockVoxels> block_{};
  int next_ = 0;
  std::array<std::int16_t, kVoxelChannels> last_{};  // of the voxel before that had the channel, in any block
};

}  // namespace onemap::mapping
