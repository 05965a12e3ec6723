// Fusion of a depth image into the truncated signed distance field (Curless and Levoy 1996), with integer sums.
#include <algorithm>
#include <array>
#include <cmath>

#include "floor_int.hpp"
#include "hal/base/twin.hpp"
#include "local/fuse_block.hpp"
#include "mapping/local/depth_range.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {
namespace {

constexpr float kRaysPerUnit =
    128;  // density of the rays that look for blocks: at 4 m they are 3 cm apart, a fifth of a block
constexpr double kFarthestPose_m = 1e6;
constexpr float kColorBand_voxels = 2;  // every corner of a cell that the surface crosses head-on is nearer than this
constexpr std::int32_t kThinBand_voxels = 3;

bool finite_and_near(const Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(pose.t[i]) <= kFarthestPose_m)) return false;
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(pose.R(i, j)) <= 2)) return false;
  }
  return true;
}

// How far from the surface a voxel takes its colour. A band of more voxels than the usual three is for models to be
// shown: there surfaces at a slant, whose crossings lie farther along the axis, have colour, too.
float color_band_m(const VoxelMapConfig& config) {
  const bool thin = config.truncation_um() <= kThinBand_voxels * config.voxel_um();
  return thin ? kColorBand_voxels * config.voxel_m : config.truncation_m;
}

}  // namespace

// Where the frame that is being fused was seen from.
struct VoxelMap::Viewpoint {
  Pose T_camera_map;
  Vector3f origin_block;           // camera centre in the map, in blocks
  Eigen::Matrix3f R_block_camera;  // directions from camera to map, metres to blocks
  fusing::FrameOnMap frame;
  bool simd = false;
};

void VoxelMap::touch(const BlockKey& key) {
  const auto part = [](std::int32_t v) { return static_cast<std::uint32_t>(v) & 3u; };
  BlockKey& lately = shared_->lately[part(key.x) | part(key.y) << 2 | part(key.z) << 4];
  if (lately == key) return;
  lately = key;
  const std::int32_t block = index_or_add(key);
  if (block < 0) {
    shared_->missing.add(key);
    return;
  }
  auto& last = touched_[static_cast<std::size_t>(block)];
  if (last == counters_.integrated_frames) return;
  last = counters_.integrated_frames;
  shared_->seen.push_back(block);
}

// All blocks that the segment passes (Amanatides and Woo 1987); units of blocks.
void VoxelMap::touch_segment(const Vector3f& from, const Vector3f& to) {
  std::array<std::int32_t, 3> at{}, direction{};
  std::array<float, 3> next{}, delta{};
  int steps = 0;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    at[k] = floor_int<std::int32_t>(from[i]);
    const std::int32_t cells = floor_int<std::int32_t>(to[i]) - at[k];
    steps += cells < 0 ? -cells : cells;
    const float length = to[i] - from[i];
    direction[k] = cells < 0 ? -1 : 1;
    delta[k] = cells == 0 ? 0.f : static_cast<float>(direction[k]) / length;
    const auto border = static_cast<float>(cells < 0 ? at[k] : at[k] + 1);
    next[k] = cells == 0 ? 2.f : (border - from[i]) / length;
  }
  touch({at[0], at[1], at[2]});
  for (; steps > 0; --steps) {
    const std::size_t k = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    at[k] += direction[k];
    next[k] += delta[k];
    touch({at[0], at[1], at[2]});
  }
}

// Step 1: the blocks that the truncation bands of the seen surface reach.
void VoxelMap::touch_seen_blocks(const Viewpoint& from) {
  const PinholeView& view = shared_->view;
  shared_->seen.clear();
  shared_->lately.fill({INT32_MIN, INT32_MIN, INT32_MIN});  // nobody's: poses end at a thousand kilometres
  const float inv_fx = 1 / view.fx(), inv_fy = 1 / view.fy();
  const int stride = view.fx() > kRaysPerUnit ? static_cast<int>(view.fx() / kRaysPerUnit) : 1;
  for (int v = 1 + stride / 2; v < view.height() - 1; v += stride) {
    const float y = (static_cast<float>(v) + 0.5f - view.cy()) * inv_fy;
    const float* depth = view.depth_m() + static_cast<std::ptrdiff_t>(v) * view.width();
    for (int u = 1 + stride / 2; u < view.width() - 1; u += stride) {
      if (!(depth[u] > 0)) continue;
      const Vector3f ray((static_cast<float>(u) + 0.5f - view.cx()) * inv_fx, y, 1);
      const Vector3f direction = from.R_block_camera * ray;
      // A truncation that is deeper than the depth does not reach behind the camera.
      touch_segment(from.origin_block + direction * std::max(kMinDepth_m, depth[u] - config_.truncation_m),
                    from.origin_block + direction * (depth[u] + config_.truncation_m));
    }
  }
}

// Step 2: every voxel of a touched block.
bool VoxelMap::fuse_block(const Viewpoint& from, std::size_t block) {
  const BlockKey key = keys_[block];
  const double voxel_m = config_.voxel_m;
  const Vector3d corner = Vector3d(key.x, key.y, key.z) * (kBlockSide * voxel_m);
  const Vector3f first = (from.T_camera_map * (corner + Vector3d::Constant(0.5 * voxel_m))).cast<float>();
  return (from.simd ? fusing::fuse_block_simd : fusing::fuse_block_plain)(from.frame, first, voxels_of(block));
}

// Of the frame that the view was loaded with.
VoxelMap::Viewpoint VoxelMap::viewpoint(const hal::FrameView& frame, const Pose& T_map_camera) const {
  const double voxel_m = config_.voxel_m, block_m = kBlockSide * voxel_m;
  const PinholeView& view = shared_->view;
  Viewpoint from;
  from.T_camera_map = T_map_camera.inverse();
  from.origin_block = (T_map_camera.t / block_m).cast<float>();
  from.R_block_camera = (T_map_camera.R / block_m).cast<float>();
  from.simd = config_.simd && simd_available();
  fusing::FrameOnMap& on_map = from.frame;
  on_map.depth_m = view.depth_m();
  on_map.source = view.source();
  on_map.rgb = frame.rgb.empty() ? nullptr : frame.rgb.data();
  on_map.fx = view.fx();
  on_map.fy = view.fy();
  on_map.cx = view.cx();
  on_map.cy = view.cy();
  on_map.right = static_cast<float>(view.width() - 1);
  on_map.bottom = static_cast<float>(view.height() - 1);
  on_map.width = static_cast<float>(view.width());
  on_map.truncation_m = config_.truncation_m;
  on_map.color_band_m = color_band_m(config_);
  on_map.step_x = (from.T_camera_map.R.col(0) * voxel_m).cast<float>();
  on_map.step_y = (from.T_camera_map.R.col(1) * voxel_m).cast<float>();
  on_map.step_z = (from.T_camera_map.R.col(2) * voxel_m).cast<float>();
  return from;
}

void VoxelMap::integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_map_camera) {
  if (!finite_and_near(T_map_camera)) {
    ++counters_.frames_refused;
    return;
  }
  ++counters_.integrated_frames;
  shared_->view.load(frame, rays, config_.max_depth_m, config_.simd);
  const Viewpoint from = viewpoint(frame, T_map_camera);
  shared_->missing.begin_frame();
  touch_seen_blocks(from);
  counters_.blocks_refused += shared_->missing.count();
  counters_.frames_short += shared_->missing.count() > 0;
  for (const std::int32_t block : shared_->seen)
    if (fuse_block(from, static_cast<std::size_t>(block))) changed_[static_cast<std::size_t>(block)] = 1;
}

}  // namespace onemap::mapping
