#include "keyframe_record.hpp"

#include <cmath>

namespace onemap::mapping {

namespace {

constexpr double kGridUnit_m = 0.00025;  // of what a keyframe keeps of its depth: up to 16.4 m

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
                                 ? static_cast<std::uint16_t>(std::lround(z / kGridUnit_m))
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
  grid.depth_scale = 1 / kGridUnit_m;
  organize(keyframe.grid_depth, grid, kGridWidth, kGridHeight, out);
}

void fill_record(const MapKeyframe& keyframe, KeyframeRecord& out) {
  out.index = keyframe.index;
  out.time = keyframe.time;
  out.T_robot_keyframe = quantize(keyframe.T_camera_robot.inverse());
  out.anchor = keyframe.anchor.keyframe;
  out.descriptor_kind = kind_of_bits(keyframe.features.set.kind);
  DepthGrid& g = out.grid;
  g.width = kGridWidth;
  g.height = kGridHeight;
  const auto fixed = [](double v) { return static_cast<std::int32_t>(std::lround(v * 1024)); };
  g.fx_fy_cx_cy = {fixed(keyframe.grid_fx), fixed(keyframe.grid_fy), fixed(keyframe.grid_cx), fixed(keyframe.grid_cy)};
  g.inverse_depth.clear();
  for (const std::uint16_t z : keyframe.grid_depth) g.inverse_depth.push_back(grid_inverse_depth(z * kGridUnit_m));
  out.features.clear();
  const FeatureFrame& f = keyframe.features;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const auto place = f.has_depth(i) ? to_place(f.point[i], g) : std::nullopt;
    if (!place) continue;
    out.features.push_back({*place, f.set.keypoints[i].laplacian, to_bits(f.set.descriptors[i], f.set.kind)});
  }
}

}  // namespace onemap::mapping
