#include "mapping/team/verify.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/local/icp.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/point_cloud.hpp"
#include "mapping/local/ransac.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kQuickFeatures = 128;               // for choosing the pairs that are worth a closer look
constexpr std::size_t kMaxCandidates = 32;                // pairs of clouds looked at closely for a pair of robots
constexpr int kQuickMatches = 8;                          // a candidate has at least so many quick matches
constexpr double kAgree_m = 0.08, kAgreeCosine = 0.9976;  // two pairs agree within 8 cm and 4 degrees
constexpr double kMinOverlap = 0.25;                      // of the source's depth cells that ICP must explain
constexpr double kMaxIcpError_m = 0.03;
constexpr double kMinAgreement = 0.8;  // on free space, of the less agreeing cloud

// A keyframe record unpacked for matching.
struct Cloud {
  FeatureSet features;
  std::vector<Vector3d> points;  // camera frame
  std::vector<Eigen::Vector2d> rays;
  OrganizedCloud grid;
  std::vector<Vector3f> cells;  // the grid's points
  Pose T_robot_keyframe;
};

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

Cloud unpack(const KeyframeRecord& record) {
  Cloud cloud;
  cloud.T_robot_keyframe = from_quantized(record.T_robot_keyframe);
  unpack_features(record, cloud);
  unpack_grid(record.grid, cloud);
  return cloud;
}

// A verified pair with its matched points, for the common fit.
struct Verified {
  PairResult result;
  std::size_t r = 0, s = 0;
  std::vector<Vector3d> points_r, points_s;  // inliers, camera frames
};

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

FeatureSet strongest(const FeatureSet& all) {
  FeatureSet some;
  some.kind = all.kind;
  const auto n = static_cast<std::ptrdiff_t>(std::min(all.size(), kQuickFeatures));
  some.keypoints.assign(all.keypoints.begin(), all.keypoints.begin() + n);
  some.descriptors.assign(all.descriptors.begin(), all.descriptors.begin() + n);
  return some;
}

struct Candidate {
  int matches;
  std::size_t r, s;
};

// The pairs of clouds with most matches among their strongest features, spread over the clouds: no cloud more than four
// times.
std::vector<Candidate> candidates(const std::vector<Cloud>& a, const std::vector<Cloud>& b) {
  std::vector<FeatureSet> quick_a, quick_b;
  for (const Cloud& c : a) quick_a.push_back(strongest(c.features));
  for (const Cloud& c : b) quick_b.push_back(strongest(c.features));
  MatchConfig config;
  config.max_ratio = 0.8f;
  Matcher matcher(config, kQuickFeatures);
  std::vector<Candidate> all;
  for (std::size_t r = 0; r < a.size(); ++r)
    for (std::size_t s = 0; s < b.size(); ++s) {
      const int n = static_cast<int>(matcher.match(quick_a[r], quick_b[s]).size());
      if (n >= kQuickMatches) all.push_back({n, r, s});
    }
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& x, const Candidate& y) { return x.matches > y.matches; });
  std::vector<int> times_r(a.size()), times_s(b.size());
  std::vector<Candidate> chosen;
  for (const Candidate& c : all) {
    if (chosen.size() == kMaxCandidates) break;
    if (times_r[c.r] == 4 || times_s[c.s] == 4) continue;
    ++times_r[c.r];
    ++times_s[c.s];
    chosen.push_back(c);
  }
  return chosen;
}

// Eq. (11): ref_a T ref_b through the clouds r and s.
Pose between_references(const Cloud& r, const Cloud& s, const Pose& T_r_s) {
  return r.T_robot_keyframe * T_r_s * s.T_robot_keyframe.inverse();
}

bool agree(const Pose& x, const Pose& y, const Vector3d& at) {
  const Pose off = x.inverse() * y;
  return 0.5 * (off.R.trace() - 1) > kAgreeCosine && (off * at - at).norm() < kAgree_m;
}

// One transform from all matched points of the agreeing pairs, in the robots' own frames; outliers of the fit leave
// twice.
double fit_common(const std::vector<Cloud>& a, const std::vector<Cloud>& b, const std::vector<const Verified*>& pairs,
                  Pose& T_a_b, int& inliers) {
  std::vector<Vector3d> points_a, points_b;
  for (const Verified* v : pairs)
    for (std::size_t i = 0; i < v->points_r.size(); ++i) {
      points_a.push_back(a[v->r].T_robot_keyframe * v->points_r[i]);
      points_b.push_back(b[v->s].T_robot_keyframe * v->points_s[i]);
    }
  std::vector<std::uint8_t> use(points_a.size(), 1);
  double rms = 0;
  for (const double bound_m : {0.10, 0.06, 0.05}) {
    Pose fitted;
    if (!fit_rigid(points_a, points_b, use, fitted)) break;
    T_a_b = fitted;
    double sum = 0;
    inliers = 0;
    for (std::size_t i = 0; i < use.size(); ++i) {
      const double squared = (points_a[i] - T_a_b * points_b[i]).squaredNorm();
      use[i] = squared < bound_m * bound_m;
      if (use[i]) sum += squared, ++inliers;
    }
    rms = inliers > 0 ? std::sqrt(sum / inliers) : 0;
  }
  return rms;
}

}  // namespace

PairResult verify_pair(const KeyframeRecord& r, const KeyframeRecord& s, const VerifyConfig& config) {
  if (r.descriptor_kind != s.descriptor_kind) return {};
  return verify_clouds(unpack(r), unpack(s), config).result;
}

LinkRecord verify_robots(const RobotId& a, std::span<const KeyframeRecord> keyframes_a, const RobotId& b,
                         std::span<const KeyframeRecord> keyframes_b, const VerifyConfig& config) {
  LinkRecord link;
  link.a = a;
  link.b = b;
  link.reason = LinkReason::too_few_matches;
  std::vector<Cloud> clouds_a, clouds_b;
  for (const auto& k : keyframes_a) clouds_a.push_back(unpack(k));
  for (const auto& k : keyframes_b) clouds_b.push_back(unpack(k));
  if (clouds_a.empty() || clouds_b.empty() || keyframes_a[0].descriptor_kind != keyframes_b[0].descriptor_kind)
    return link;

  std::vector<Verified> verified;
  int best_refused = -1;
  for (const Candidate& c : candidates(clouds_a, clouds_b)) {
    Verified v = verify_clouds(clouds_a[c.r], clouds_b[c.s], config);
    v.r = c.r;
    v.s = c.s;
    if (v.result.reason == LinkReason::accepted) {
      verified.push_back(std::move(v));
    } else if (v.result.matches > best_refused) {  // what the refusal will say, if it is one
      best_refused = v.result.matches;
      link.reason = v.result.reason;
      link.keyframe_a = keyframes_a[c.r].index;
      link.keyframe_b = keyframes_b[c.s].index;
      link.inliers = static_cast<std::uint32_t>(v.result.inliers);
    }
  }
  std::vector<const Verified*> best;
  for (const Verified& v : verified) {
    const Pose T = between_references(clouds_a[v.r], clouds_b[v.s], v.result.T_r_s);
    std::vector<const Verified*> support;
    for (const Verified& other : verified) {
      const Vector3d at = clouds_b[other.s].T_robot_keyframe.t;
      if (agree(T, between_references(clouds_a[other.r], clouds_b[other.s], other.result.T_r_s), at))
        support.push_back(&other);
    }
    if (support.size() > best.size()) best = support;
  }
  if (best.empty()) return link;
  link.supporting_pairs = static_cast<std::uint32_t>(best.size());
  const Verified& top = **std::max_element(best.begin(), best.end(), [](const Verified* x, const Verified* y) {
    return x->result.inliers < y->result.inliers;
  });
  link.keyframe_a = keyframes_a[top.r].index;
  link.keyframe_b = keyframes_b[top.s].index;
  link.ratio_e4 = static_cast<std::uint32_t>(std::lround(top.result.ratio * 10000));
  if (best.size() < static_cast<std::size_t>(config.min_supporting_pairs) &&
      top.result.inliers < config.strong_inliers) {
    link.reason = LinkReason::inconsistent;
    link.inliers = static_cast<std::uint32_t>(top.result.inliers);
    return link;
  }
  Pose T_a_b = between_references(clouds_a[top.r], clouds_b[top.s], top.result.T_r_s);
  int inliers = 0;
  const double rms = fit_common(clouds_a, clouds_b, best, T_a_b, inliers);
  link.reason = LinkReason::accepted;
  link.inliers = static_cast<std::uint32_t>(inliers);
  link.error_um = static_cast<std::int32_t>(std::lround(rms * 1e6));
  link.T_a_b = quantize(T_a_b);
  return link;
}

}  // namespace onemap::mapping
