#include "local/fuse_block.hpp"

#include <array>
#include <cstddef>

#include "mapping/local/block_key.hpp"

namespace onemap::mapping::fusing {
namespace {

// The noise of structured light grows with the square of the depth, so information falls with its fourth power; the
// square is the usual compromise that keeps far surfaces alive: 16 at 1 m, 4 at 2 m, 2 from 2.8 m on.
int observation_weight(float depth_m) {
  constexpr auto kMost = static_cast<float>(kMostWeight), kLeast = static_cast<float>(kLeastWeight);
  const float w = kMost / (depth_m * depth_m);
  return w >= kMost ? kMostWeight : (w <= kLeast ? kLeastWeight : static_cast<int>(w));
}

// A row of voxels along x as the camera sees it.
struct Row {
  std::array<float, kBlockSide> z{};
  std::array<std::int32_t, kBlockSide> pixel{};
};

Row project(const FrameOnMap& frame, const Vector3f& p) {
  const float px = p[0], py = p[1], pz = p[2];
  const float sx = frame.step_x[0], sy = frame.step_x[1], sz = frame.step_x[2];
  Row row;
  for (std::size_t i = 0; i < kBlockSide; ++i) {
    const auto n = static_cast<float>(static_cast<int>(i));
    const float z_m = pz + n * sz, Z = z_m > kNearest_m ? z_m : kBehind_m;
    const float inv = 1.f / Z;
    float u = (px + n * sx) * inv * frame.fx + frame.cx;
    float v = (py + n * sy) * inv * frame.fy + frame.cy;
    u = u > 0.f ? u : 0.f;
    v = v > 0.f ? v : 0.f;
    u = u < frame.right ? u : frame.right;
    v = v < frame.bottom ? v : frame.bottom;
    const auto iu = static_cast<float>(static_cast<std::int32_t>(u)),
               iv = static_cast<float>(static_cast<std::int32_t>(v));
    row.z[i] = Z;
    row.pixel[i] = static_cast<std::int32_t>(iv * frame.width + iu);  // below 2^24: exact
  }
  return row;
}

bool fuse_row(const FrameOnMap& frame, const Row& row, float to_units, Voxel* voxels) {
  bool changed = false;
  for (std::size_t i = 0; i < kBlockSide; ++i) {
    const float d = frame.depth_m[row.pixel[i]];
    const float sdf = d - row.z[i];
    if (!(d > 0.f && sdf <= frame.truncation_m && sdf >= -frame.truncation_m)) continue;
    const int tsdf = static_cast<int>(sdf * to_units + (static_cast<float>(kTsdfOne) + 0.5f)) - kTsdfOne;
    voxels[i].add_tsdf(tsdf, observation_weight(d));
    changed = true;
    if (sdf > frame.color_band_m || sdf < -frame.color_band_m || frame.rgb == nullptr) continue;
    const std::uint8_t* color = frame.rgb + 3 * static_cast<std::ptrdiff_t>(frame.source[row.pixel[i]]);
    voxels[i].add_color(color[0], color[1], color[2]);
  }
  return changed;
}

}  // namespace

bool fuse_block_plain(const FrameOnMap& frame, const Vector3f& first, Voxel* voxels) {
  const float to_units = static_cast<float>(kTsdfOne) / frame.truncation_m;
  bool changed = false;
  for (int z = 0; z < kBlockSide; ++z)
    for (int y = 0; y < kBlockSide; ++y, voxels += kBlockSide) {
      const Vector3f p = first + frame.step_y * static_cast<float>(y) + frame.step_z * static_cast<float>(z);
      changed = fuse_row(frame, project(frame, p), to_units, voxels) || changed;
    }
  return changed;
}

}  // namespace onemap::mapping::fusing
