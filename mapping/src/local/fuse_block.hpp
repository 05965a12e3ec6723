#pragma once
#include <cstdint>

#include "mapping/geometry.hpp"
#include "mapping/local/voxel.hpp"

namespace onemap::mapping::fusing {

// A frame that is being fused, as every block of the map needs it.
struct FrameOnMap {
  const float* depth_m = nullptr;          // of the pinhole view; 0: none
  const std::int32_t* source = nullptr;    // of its pixels in the frame
  const std::uint8_t* rgb = nullptr;       // of the frame's pixels; nullptr: none
  float fx = 0, fy = 0, cx = 0, cy = 0;    // of the pinhole view
  float right = 0, bottom = 0, width = 0;  // its last column, last row, and how many columns
  float truncation_m = 0;                  // how far from the surface a voxel takes its distance,
  float color_band_m = 0;                  // and its colour
  Vector3f step_x, step_y, step_z;         // one voxel along each axis of the map, in the camera's frame
};

// Every voxel of a block, the first of them at `first` in the camera's frame, gets the signed distance (along the
// optical axis) to the surface at its pixel. false: none did. The twins write the same bytes.
bool fuse_block_plain(const FrameOnMap& frame, const Vector3f& first, Voxel* voxels);
bool fuse_block_simd(const FrameOnMap& frame, const Vector3f& first, Voxel* voxels);

inline constexpr float kBehind_m = 1e6f;  // stands for the z of what is behind the camera: no depth agrees with it
inline constexpr float kNearest_m = 1e-3f;
inline constexpr int kMostWeight = 16, kLeastWeight = 2;  // of an observation; what was seen once is surface

}  // namespace onemap::mapping::fusing
