#pragma once
#include <array>
#include <cstdint>

#include "mapping/records/submap.hpp"

// How a submap's voxels stand on the wire: as steps, each as its change from what its neighbours in the block let
// expect, so that what is smooth becomes small numbers.
namespace onemap::mapping {

// Half a step is the largest error: 2 % of the truncation (1.2 mm of 6 cm, less than a depth camera's noise at a
// metre), half of a weight, 3 of 255 in green and 9 in red and blue (which are steps of their distance to green).
inline constexpr int kTsdfStep = 40, kGreenStep = 6, kChromaStep = 12;
inline constexpr std::array<std::uint8_t, 7> kWeightSteps{1, 3, 8, 20, 50, 120, 255};

enum VoxelChannel : std::uint8_t { kTsdf, kWeight, kGreen, kRed, kBlue, kVoxelChannels };  // red, blue: minus green

struct VoxelSteps {
  std::array<std::int16_t, kVoxelChannels> value{};
  bool seen = false, colored = false;
};
VoxelSteps to_steps(const SubmapVoxel& voxel);  // the nearest

// Between the mean of 1 to 3 planes' and that of 2 or 3 neighbours' steps, to the nearest step, in whole numbers: the
// reciprocal is rounded to 1 / 65536, and this is what the coding means.
constexpr int half_way(int plane_sum, int planes, int sum, int neighbours) {
  const int parts = 2 * planes * neighbours;
  return ((plane_sum * neighbours + sum * planes) * ((65536 + parts / 2) / parts) + 32768) >> 16;
}

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
