#pragma once
#include <cstddef>
#include <cstdint>

#include "hal/base/range.hpp"
#include "hal/base/result.hpp"
#include "hal/lens.hpp"
#include "mapping/local/depth_range.hpp"
#include "mapping/local/features.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {

struct LocalMapperConfig {
  DescriptorKind features = DescriptorKind::surf;
  int max_features = 500;
  int max_keyframes = 200;  // kept for matching and relocalisation; full: the most redundant old one makes room
  double keyframe_translation_m = 0.10;  // motion since the nearest keyframe that makes a new one
  double keyframe_rotation_deg = 8.0;
  double min_motion_m = 0.03;  // the paper: frames whose motion is under a threshold are not added to the map
  double min_motion_deg = 2.0;
  VoxelMapConfig map;  // of the open submaps together; its image_pixels are the camera's, whatever they say
  std::size_t shelf_bytes = 16u << 20;  // submaps that the camera has left, to be opened again when it comes back
  std::uint64_t seed = 1;
};

// The eight keyframes whose poses still move, the reference and the one that is being added.
inline constexpr int kMinKeyframes = 10;

// What a mapper accepts; the voxel's and the truncation's are what records can say.
struct LocalMapperLimits {
  static constexpr Range<int> max_features{50, 1000};
  static constexpr Range<int> max_keyframes{kMinKeyframes, 10000};
  static constexpr Range<double> keyframe_translation_m{0.01, 5}, keyframe_rotation_deg{0.5, 90};
  static constexpr Range<double> min_motion_m{0, 1}, min_motion_deg{0, 45};
  static constexpr Range<float> voxel_m{0.001f, 1.0f};
  static constexpr Range<std::int64_t> truncation_voxels{2, 100};
  static constexpr Range<float> max_depth_m{0.5f, kMaxDepth_m};
  static constexpr Range<std::size_t> budget_bytes{std::size_t{1} << 20, std::size_t{64} << 30};
  static constexpr Range<int> image_side_px{48, 4096};
  static constexpr Range<double> focal_length_widths = hal::kFocalLengthWidths, depth_scale = hal::kDepthScale;
};

// Whether a mapper can be made of these two, each bound and what must hold between them: a truncation of so many
// voxels, room for at least one block beside what an image of this camera takes, a lens that can be inverted. The
// error's place is the value's name here ("max_keyframes", "map.voxel_m", "camera.fx"), its reason says what was found
// and what is accepted. LocalMapper must not be given what this refuses.
Status check(const LocalMapperConfig& config, const hal::Intrinsics& camera);

}  // namespace onemap::mapping
