#include "team/verify_clouds.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/local/icp.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/point_cloud.hpp"
#include "mapping/local/ransac.hpp"

namespace onemap::mapping {

namespace {

constexpr double kMinOverlap = 0.25;  // of the source's depth cells that ICP must explain
constexpr double kMaxIcpError_m = 0.03;
constexpr double kMinAgreement = 0.8;  // on free space, of the less agreeing cloud

void unpack_features(const KeyframeRecord& record, Cloud& cloud) {
  cloud.features.kind = record.descriptor_kind;
  cloud.features.reserve(record.features.size());
  for (const KeyframeFeature& f : record.features) {
    Keypoint k;
    k.laplacian = f.laplacian;
    cloud.features.keypoints.push_back(k);
    cloud.features.descriptors.push_back(f.descriptor);
    const Vector3d p(f.point[0] * kPointUnit_m, f.point[1] * kPointUnit_m, f.point[2] * kPointUnit_m);
    cloud.points.push_back(p);
    cloud.rays.emplace_back(p.x() / p.z(), p.y() / p.z());
  }
}

void unpack_grid(const DepthGrid& grid, Cloud& cloud) {
  if (grid.width == 0 || grid.height == 0) return;
  hal::Intrinsics k;
  k.width = grid.width;
  k.height = grid.height;
  k.fx = grid.fx_fy_cx_cy[0] / 1024.0;
  k.fy = grid.fx_fy_cx_cy[1] / 1024.0;
  k.cx = grid.fx_fy_cx_cy[2] / 1024.0;
  k.cy = grid.fx_fy_cx_cy[3] / 1024.0;
  k.depth_scale = 1 / kPointUnit_m;
  organize(grid.depth, k, grid.width, grid.height, cloud.grid);
  for (const Vector3f& p : cloud.grid.points)
    if (p.z() > 0) cloud.cells.push_back(p);
}

}  // namespace

Cloud unpack(const KeyframeRecord& record) {
  Cloud cloud;
  cloud.T_robot_keyframe = from_quantized(record.T_robot_keyframe);
  unpack_features(record, cloud);
  unpack_grid(record.grid, cloud);
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

LinkReason refine_by_icp(const Cloud& r, const Cloud& s, PairResult& result) {
  IcpConfig config;
  config.max_distance_m = 0.08f;
  const IcpResult icp = Icp(config).align(r.grid, s.cells, result.T_r_s);
  result.error_m = icp.error_m;
  const bool overlaps = icp.inliers >= kMinOverlap * static_cast<double>(s.cells.size());
  if (icp.reason == IcpReason::too_few_inliers || !overlaps || icp.error_m > kMaxIcpError_m)
    return LinkReason::icp_failed;
  const Pose off = result.T_r_s.inverse() * icp.T_target_source;
  if (icp.converged && off.t.norm() < kAgree_m && 0.5 * (off.R.trace() - 1) > kAgreeCosine)
    result.T_r_s = icp.T_target_source;
  const double agreement = std::min(free_space_agreement(r.grid, s.cells, result.T_r_s),
                                    free_space_agreement(s.grid, r.cells, result.T_r_s.inverse()));
  return agreement >= kMinAgreement ? LinkReason::accepted : LinkReason::inconsistent;
}

}  // namespace

Verified verify_clouds(const Cloud& r, const Cloud& s, const VerifyConfig& config) {
  Verified v;
  const std::size_t most = std::max(r.points.size(), s.points.size());
  if (std::min(r.points.size(), s.points.size()) < static_cast<std::size_t>(config.min_matches)) return v;
  MatchConfig match_config;
  match_config.max_ratio = config.max_ratio;
  Matcher matcher(match_config, most);
  const auto matches = matcher.match(r.features, s.features);
  v.result.matches = static_cast<int>(matches.size());
  if (v.result.matches < config.min_matches) return v;

  std::vector<Eigen::Vector2d> rays_r, rays_s;
  for (const Match& m : matches) rays_r.push_back(r.rays[m.a]), rays_s.push_back(s.rays[m.b]);
  std::vector<std::uint8_t> kept(matches.size());
  FundamentalConfig f_config;
  f_config.seed = config.seed;
  f_config.threshold = 3.0 / 525;  // views of two robots are farther apart than two frames of one
  Matrix3d F;
  v.result.reason = LinkReason::fundamental_failed;
  if (!FundamentalRansac(f_config, most).estimate(rays_r, rays_s, kept, F).ok()) return v;

  std::vector<Vector3d> points_r, points_s;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Vector3d &p = r.points[matches[i].a], &q = s.points[matches[i].b];
    const auto coherent = [](double z) {
      return z >= static_cast<double>(kMinDepth_m) && z <= static_cast<double>(kMaxDepth_m);
    };
    if (kept[i] && coherent(p.z()) && coherent(q.z())) points_r.push_back(p), points_s.push_back(q);
  }
  v.result.reason = LinkReason::depth_incoherent;
  if (points_r.size() < static_cast<std::size_t>(config.min_inliers)) return v;

  RigidConfig rigid_config;
  rigid_config.seed = config.seed;
  rigid_config.min_inliers = config.min_inliers;
  std::vector<std::uint8_t> inlier(points_r.size());
  const RansacResult ransac = RigidRansac(rigid_config, most).estimate(points_r, points_s, inlier, v.result.T_r_s);
  v.result.inliers = ransac.inliers;
  v.result.ratio = ransac.inliers / static_cast<double>(std::min(r.points.size(), s.points.size()));
  v.result.reason = LinkReason::ransac_failed;
  if (!ransac.ok()) return v;
  for (std::size_t i = 0; i < inlier.size(); ++i)
    if (inlier[i]) v.points_r.push_back(points_r[i]), v.points_s.push_back(points_s[i]);
  v.result.reason = refine_by_icp(r, s, v.result);
  return v;
}

PairResult verify_pair(const KeyframeRecord& r, const KeyframeRecord& s, const VerifyConfig& config) {
  if (r.descriptor_kind != s.descriptor_kind) return {};
  return verify_clouds(unpack(r), unpack(s), config).result;
}

}  // namespace onemap::mapping
