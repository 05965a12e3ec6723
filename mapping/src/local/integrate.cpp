// Fusion of a depth image into the truncated signed distance field (Curless and Levoy 1996), with integer sums.
#include <algorithm>
#include <array>
#include <cmath>

#include "floor_int.hpp"
#include "mapping/local/depth_range.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {
namespace {

constexpr float kRaysPerUnit =
    128;  // density of the rays that look for blocks: at 4 m they are 3 cm apart, a fifth of a block
constexpr double kFarthestPose_m = 1e6;
constexpr float kBehind_m = 1e6f;       // stands for the z of what is behind the camera: no depth agrees with it
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

// The noise of structured light grows with the square of the depth, so information falls with its fourth power; the
// square is the usual compromise that keeps far surfaces alive: 16 at 1 m, 4 at 2 m, 1 at 4 m.
int observation_weight(float depth_m) {
  const float w = 16.f / (depth_m * depth_m);
  return w >= 16.f ? 16 : (w <= 1.f ? 1 : static_cast<int>(w));
}

// How far from the surface a voxel takes its colour. A band of more voxels than the usual three is for models to be
// shown: there surfaces at a slant, whose crossings lie farther along the axis, have colour, too.
float color_band_m(const VoxelMapConfig& config) {
  const bool thin = config.truncation_um() <= kThinBand_voxels * config.voxel_um();
  return thin ? kColorBand_voxels * config.voxel_m : config.truncation_m;
}

// A row of voxels along x as the camera sees it.
struct Row {
  std::array<float, kBlockSide> z{};
  std::array<std::int32_t, kBlockSide> pixel{};
};

}  // namespace

// Where the frame that is being fused was seen from.
struct VoxelMap::Viewpoint {
  Pose T_camera_map;
  Vector3f step_x, step_y, step_z;  // one voxel along each axis of the map, in the camera frame
  Vector3f origin_block;            // camera centre in the map, in blocks
  Eigen::Matrix3f R_block_camera;   // directions from camera to map, metres to blocks
};

void VoxelMap::touch(const BlockKey& key) {
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
  const float inv_fx = 1 / view.fx(), inv_fy = 1 / view.fy();
  const int stride = view.fx() > kRaysPerUnit ? static_cast<int>(view.fx() / kRaysPerUnit) : 1;
  for (int v = 1 + stride / 2; v < view.height() - 1; v += stride) {
    const float y = (static_cast<float>(v) + 0.5f - view.cy()) * inv_fy;
    const float* depth = view.depth_m() + static_cast<std::ptrdiff_t>(v) * view.width();
    for (int u = 1 + stride / 2; u < view.width() - 1; u += stride) {
      if (depth[u] == 0) continue;
      const Vector3f ray((static_cast<float>(u) + 0.5f - view.cx()) * inv_fx, y, 1);
      const Vector3f direction = from.R_block_camera * ray;
      // A truncation that is deeper than the depth does not reach behind the camera.
      touch_segment(from.origin_block + direction * std::max(kMinDepth_m, depth[u] - config_.truncation_m),
                    from.origin_block + direction * (depth[u] + config_.truncation_m));
    }
  }
}

// Step 2: every voxel of a touched block gets the signed distance (along the optical axis) to the surface at its pixel.
bool VoxelMap::fuse_block(const Viewpoint& from, std::size_t block, std::span<const std::uint8_t> rgb) {
  const BlockKey key = keys_[block];
  const double voxel_m = config_.voxel_m;
  const Vector3d corner = Vector3d(key.x, key.y, key.z) * (kBlockSide * voxel_m);
  const Vector3f first = (from.T_camera_map * (corner + Vector3d::Constant(0.5 * voxel_m))).cast<float>();
  const PinholeView& view = shared_->view;
  const float right = static_cast<float>(view.width() - 1), bottom = static_cast<float>(view.height() - 1);
  const float fx = view.fx(), fy = view.fy(), cx = view.cx(), cy = view.cy();
  const float width = static_cast<float>(view.width());
  const float truncation = config_.truncation_m, to_units = static_cast<float>(kTsdfOne) / truncation;
  const float color_band = color_band_m(config_);
  const float* depth = view.depth_m();
  const float sx = from.step_x[0], sy = from.step_x[1], sz = from.step_x[2];
  Voxel* voxel = voxels_of(block);
  bool changed = false;
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y, voxel += kBlockSide) {
      const Vector3f p = first + from.step_y * static_cast<float>(y) + from.step_z * static_cast<float>(z);
      const float px = p[0], py = p[1], pz = p[2];
      Row row;
      for (std::size_t i = 0; i < kBlockSide; ++i) {
        const auto n = static_cast<float>(static_cast<int>(i));
        const float z_m = pz + n * sz, Z = z_m > 1e-3f ? z_m : kBehind_m;
        const float inv = 1.f / Z;
        float u = (px + n * sx) * inv * fx + cx;
        float v = (py + n * sy) * inv * fy + cy;
        u = u > 0.f ? u : 0.f;
        v = v > 0.f ? v : 0.f;
        u = u < right ? u : right;
        v = v < bottom ? v : bottom;
        const auto iu = static_cast<float>(static_cast<std::int32_t>(u)),
                   iv = static_cast<float>(static_cast<std::int32_t>(v));
        row.z[i] = Z;
        row.pixel[i] = static_cast<std::int32_t>(iv * width + iu);  // below 2^24: exact
      }
      for (std::size_t i = 0; i < kBlockSide; ++i) {
        const float d = depth[row.pixel[i]];
        const float sdf = d - row.z[i];
        if (!(d > 0.f && sdf <= truncation && sdf >= -truncation)) continue;
        const int tsdf = static_cast<int>(sdf * to_units + (static_cast<float>(kTsdfOne) + 0.5f)) - kTsdfOne;
        voxel[i].add_tsdf(tsdf, observation_weight(d));
        changed = true;
        if (sdf > color_band || sdf < -color_band || rgb.empty()) continue;
        const auto* color = &rgb[3 * static_cast<std::size_t>(view.source()[row.pixel[i]])];
        voxel[i].add_color(color[0], color[1], color[2]);
      }
    }
  }
  return changed;
}

void VoxelMap::integrate(const hal::FrameView& frame, const RayTable& rays, const Pose& T_map_camera) {
  if (!finite_and_near(T_map_camera)) {
    ++counters_.frames_refused;
    return;
  }
  ++counters_.integrated_frames;
  shared_->view.load(frame, rays, config_.max_depth_m);
  Viewpoint from;
  from.T_camera_map = T_map_camera.inverse();
  const double voxel_m = config_.voxel_m, block_m = kBlockSide * voxel_m;
  from.step_x = (from.T_camera_map.R.col(0) * voxel_m).cast<float>();
  from.step_y = (from.T_camera_map.R.col(1) * voxel_m).cast<float>();
  from.step_z = (from.T_camera_map.R.col(2) * voxel_m).cast<float>();
  from.origin_block = (T_map_camera.t / block_m).cast<float>();
  from.R_block_camera = (T_map_camera.R / block_m).cast<float>();
  shared_->missing.begin_frame();
  touch_seen_blocks(from);
  counters_.blocks_refused += shared_->missing.count();
  counters_.frames_short += shared_->missing.count() > 0;
  for (const std::int32_t block : shared_->seen)
    if (fuse_block(from, static_cast<std::size_t>(block), frame.rgb)) changed_[static_cast<std::size_t>(block)] = 1;
}

}  // namespace onemap::mapping
