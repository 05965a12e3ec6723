#include "keyframe_record.hpp"

#include <cmath>

namespace onemap::mapping {

namespace {

constexpr int kRecordStride = 2;

std::int16_t units(double metres) { return static_cast<std::int16_t>(std::lround(metres / kPointUnit_m)); }
bool fits(double metres) { return std::abs(metres) < 32767 * kPointUnit_m; }

}  // namespace

void store_grid(const OrganizedCloud& cloud, MapKeyframe& keyframe) {
  keyframe.grid_fx = static_cast<double>(cloud.fx);
  keyframe.grid_fy = static_cast<double>(cloud.fy);
  keyframe.grid_cx = static_cast<double>(cloud.cx);
  keyframe.grid_cy = static_cast<double>(cloud.cy);
  keyframe.grid_depth.resize(cloud.points.size());
  for (std::size_t i = 0; i < keyframe.grid_depth.size(); ++i) {
    const double z = static_cast<double>(cloud.points[i].z());
    keyframe.grid_depth[i] = z > 0 && z <= static_cast<double>(kMaxDepth_m)
                                 ? static_cast<std::uint16_t>(std::lround(z / kPointUnit_m))
                                 : std::uint16_t{0};
  }
}

void grid_cloud(const MapKeyframe& keyframe, OrganizedCloud& out) {
  hal::Intrinsics grid;
  grid.width = kGridWidth;
  grid.height = kGridHeight;
  grid.fx = keyframe.grid_fx;
  grid.fy = keyframe.grid_fy;
  grid.cx = keyframe.grid_cx;
  grid.cy = keyframe.grid_cy;
  grid.depth_scale = 1 / kPointUnit_m;
  organize(keyframe.grid_depth, grid, kGridWidth, kGridHeight, out);
}

void fill_record(const MapKeyframe& keyframe, KeyframeRecord& out) {
  out.index = keyframe.index;
  out.time = keyframe.time;
  out.T_robot_keyframe = quantize(keyframe.T_camera_robot.inverse());
  out.anchor = keyframe.anchor.keyframe;
  out.descriptor_kind = keyframe.features.set.kind;
  out.features.clear();
  const FeatureFrame& f = keyframe.features;
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (!f.has_depth(i)) continue;
    const Vector3d& p = f.point[i];
    if (!fits(p.x()) || !fits(p.y()) || !fits(p.z())) continue;
    out.features.push_back(
        {{units(p.x()), units(p.y()), units(p.z())}, f.set.keypoints[i].laplacian, f.set.descriptors[i]});
  }
  DepthGrid& g = out.grid;
  g.width = kGridWidth / kRecordStride;
  g.height = kGridHeight / kRecordStride;
  const auto fixed = [](double v) { return static_cast<std::int32_t>(std::lround(v * 1024 / kRecordStride)); };
  g.fx_fy_cx_cy = {fixed(keyframe.grid_fx), fixed(keyframe.grid_fy), fixed(keyframe.grid_cx), fixed(keyframe.grid_cy)};
  g.depth.clear();
  for (int v = 0; v < kGridHeight; v += kRecordStride)
    for (int u = 0; u < kGridWidth; u += kRecordStride)
      g.depth.push_back(keyframe.grid_depth[static_cast<std::size_t>(v * kGridWidth + u)]);
}

}  // namespace onemap::mapping
