#include "team/verify_clouds.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/local/depth_range.hpp"
#include "mapping/local/icp.hpp"
#include "mapping/local/two_view.hpp"

namespace onemap::mapping {

namespace {

constexpr double kMinOverlap = 0.25;  // of the source's depth cells that ICP must explain
constexpr double kMaxIcpError_m = 0.03;
constexpr int kCellStride = 2;         // of the grid's points, every second row and column is enough to align by
constexpr double kMinAgreement = 0.8;  // on free space, of the less agreeing cloud

bool is_coherent(double z_m) {
  return z_m >= static_cast<double>(kMinDepth_m) && z_m <= static_cast<double>(kMaxDepth_m);
}

void unpack_features(const KeyframeRecord& record, FeatureCloud& out) {
  out.set.kind = record.descriptor_kind;
  out.reserve(record.features.size());
  for (const KeyframeFeature& f : record.features) {
    Keypoint k;
    k.laplacian = f.laplacian;
    out.set.keypoints.push_back(k);
    out.set.descriptors.push_back(from_bits(f.bits));
    const Vector3d p = place_point(f.place, record.grid);
    out.ray.push_back(place_ray(f.place, record.grid));
    out.point.push_back(is_coherent(p.z()) ? p : Vector3d::Zero());
  }
}

void unpack_grid(const DepthGrid& grid, Normals normals, Cloud& cloud) {
  OrganizedCloud& out = cloud.grid;
  out.width = grid.width;
  out.height = grid.height;
  const auto along = [](std::int32_t k) { return static_cast<float>(k / 1024.0); };
  out.fx = along(grid.fx_fy_cx_cy[0]), out.fy = along(grid.fx_fy_cx_cy[1]);
  out.cx = along(grid.fx_fy_cx_cy[2]), out.cy = along(grid.fx_fy_cx_cy[3]);
  std::vector<float> depth_m;
  depth_m.reserve(grid.inverse_depth.size());
  for (const std::uint16_t q : grid.inverse_depth) depth_m.push_back(static_cast<float>(grid_depth_m(q)));
  organize_grid(depth_m, normals, out);
  for (int v = 0; v < out.height; v += kCellStride)
    for (int u = 0; u < out.width; u += kCellStride)
      if (const Vector3f& p = out.points[out.index(u, v)]; p.z() > 0) cloud.cells.push_back(p);
}

}  // namespace

Cloud unpack(const KeyframeRecord& record, Normals normals) {
  Cloud cloud;
  cloud.T_robot_keyframe = from_quantized(record.T_robot_keyframe);
  unpack_features(record, cloud.features);
  unpack_grid(record.grid, normals, cloud);
  return cloud;
}

namespace {

// How far two depth grids agree on what is empty: of the points of one that fall on readings of the other, the share
// that does not lie in space that the other saw through. Points behind a surface are hidden, not in conflict.
double free_space_agreement(const OrganizedCloud& seen, const std::vector<Vector3f>& points,
                            const Pose& T_seen_points) {
  int agree = 0, conflict = 0;
  for (const Vector3f& point : points) {
    const Vector3d p = T_seen_points * point.cast<double>();
    if (p.z() < static_cast<double>(kMinDepth_m)) continue;
    const double u = static_cast<double>(seen.fx) * p.x() / p.z() + static_cast<double>(seen.cx) + 0.5;
    const double v = static_cast<double>(seen.fy) * p.y() / p.z() + static_cast<double>(seen.cy) + 0.5;
    if (u < 0 || v < 0 || u >= seen.width || v >= seen.height) continue;
    const auto cell = static_cast<std::size_t>(v) * static_cast<std::size_t>(seen.width) + static_cast<std::size_t>(u);
    const double z = static_cast<double>(seen.points[cell].z());
    if (z <= 0) continue;
    const double margin_m = 0.05 + 0.02 * z * z;
    agree += std::abs(p.z() - z) <= margin_m;
    conflict += p.z() < z - 2 * margin_m;
  }
  return agree + conflict > 0 ? agree / static_cast<double>(agree + conflict) : 0;
}

std::uint32_t in_1e4(double share) { return static_cast<std::uint32_t>(std::lround(1e4 * share)); }

LinkReason refine_by_icp(const Cloud& r, const Cloud& s, PairResult& result) {
  IcpConfig config;
  config.max_distance_m = 0.08f;
  const IcpResult icp = Icp(config).align(r.grid, s.cells, result.T_r_s);
  result.error_m = icp.error_m;
  const double overlap = s.cells.empty() ? 0 : icp.inliers / static_cast<double>(s.cells.size());
  result.measured = in_1e4(overlap);
  if (icp.reason == IcpReason::too_few_inliers || overlap < kMinOverlap) return LinkReason::little_overlap;
  result.measured = static_cast<std::uint32_t>(std::lround(1e6 * std::min(icp.error_m, 1000.0)));
  if (icp.error_m > kMaxIcpError_m) return LinkReason::icp_failed;
  const Pose off = result.T_r_s.inverse() * icp.T_target_source;
  if (icp.converged && off.t.norm() < kAgree_m && rotation_cosine(off.R) > kAgreeCosine)
    result.T_r_s = icp.T_target_source;
  const double agreement = std::min(free_space_agreement(r.grid, s.cells, result.T_r_s),
                                    free_space_agreement(s.grid, r.cells, result.T_r_s.inverse()));
  result.measured = in_1e4(agreement);
  return agreement >= kMinAgreement ? LinkReason::accepted : LinkReason::seen_through;
}

TwoViewConfig two_view_config(const VerifyConfig& config) {
  TwoViewConfig out;
  out.match.max_ratio = config.max_ratio;
  out.look_up = LookUp::b_in_a;
  out.min_matches = config.min_matches;
  out.fundamental.seed = config.seed;
  out.fundamental.threshold = 3.0 / 525;  // views of two robots are farther apart than two frames of one
  out.min_coherent = config.min_inliers;
  out.rigid.seed = config.seed;
  out.rigid.min_inliers = config.min_inliers;
  return out;
}

LinkReason link_reason(TwoViewReason reason) {
  switch (reason) {
    case TwoViewReason::ok:
      return LinkReason::accepted;
    case TwoViewReason::too_few_matches:
      return LinkReason::too_few_matches;
    case TwoViewReason::fundamental_failed:
      return LinkReason::fundamental_failed;
    case TwoViewReason::depth_incoherent:
      return LinkReason::depth_incoherent;
    case TwoViewReason::ransac_failed:
      break;
  }
  return LinkReason::ransac_failed;
}

}  // namespace

// s is the first image of the two-view, r the second: T_b_a is then T_r_s.
Verified verify_clouds(const Cloud& r, const Cloud& s, const VerifyConfig& config) {
  Verified v;
  const auto [fewest, most] = std::minmax({r.features.size(), s.features.size()});
  if (fewest < static_cast<std::size_t>(config.min_matches)) return v;
  TwoView two_view(two_view_config(config), most);
  const TwoViewResult& motion = two_view.relate(s.features, r.features);
  v.result.matches = static_cast<int>(motion.matches.size());
  v.result.inliers = motion.inliers;
  v.result.ratio = motion.inliers / static_cast<double>(fewest);
  v.result.reason = link_reason(motion.reason);
  const bool agreeing = v.result.reason == LinkReason::ransac_failed;
  v.result.measured = static_cast<std::uint32_t>(agreeing ? v.result.inliers : v.result.matches);
  if (motion.reason != TwoViewReason::ok) return v;
  v.result.T_r_s = motion.T_b_a;
  for (std::size_t i = 0; i < motion.matches.size(); ++i) {
    if (!motion.kept[i]) continue;
    v.points_r.push_back(r.features.point[motion.matches[i].b]);
    v.points_s.push_back(s.features.point[motion.matches[i].a]);
  }
  v.result.reason = refine_by_icp(r, s, v.result);
  return v;
}

}  // namespace onemap::mapping
