#include "mapping/team/verify.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/local/rigid.hpp"
#include "team/verify_clouds.hpp"

namespace onemap::mapping {

namespace {

// Eq. (11): ref_a T ref_b through the clouds r and s.
Pose between_references(const Verified& v) { return v.T_a_r * v.result.T_r_s * v.T_b_s.inverse(); }

bool agree(const Pose& x, const Pose& y, const Vector3d& at) {
  const Pose off = x.inverse() * y;
  return rotation_cosine(off.R) > kAgreeCosine && (off * at - at).norm() < kAgree_m;
}

// One transform from all matched points of the agreeing pairs, in the robots' own frames; outliers of the fit leave
// twice.
double fit_common(const std::vector<const Verified*>& pairs, Pose& T_a_b, int& inliers) {
  std::vector<Vector3d> points_a, points_b;
  for (const Verified* v : pairs)
    for (std::size_t i = 0; i < v->points_r.size(); ++i) {
      points_a.push_back(v->T_a_r * v->points_r[i]);
      points_b.push_back(v->T_b_s * v->points_s[i]);
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

// Looks closely at the candidates; their clouds are unpacked one pair at a time. Notes in `link` why the most promising
// of the refused was refused. Nothing when stopped.
std::optional<std::vector<Verified>> verify_candidates(const KeyframeSource& a, const KeyframeSource& b,
                                                       const std::vector<CloudPair>& chosen, const VerifyConfig& config,
                                                       const std::function<bool()>& stop, LinkRecord& link) {
  std::vector<Verified> verified;
  int best_refused = -1;
  for (const CloudPair& c : chosen) {
    if (stop()) return std::nullopt;
    const KeyframeRecord r = a.load(c.r), s = b.load(c.s);
    const Cloud cloud_r = unpack(r), cloud_s = unpack(s, Normals::none);
    Verified v = verify_clouds(cloud_r, cloud_s, config);
    v.keyframe_r = r.index;
    v.keyframe_s = s.index;
    v.T_a_r = cloud_r.T_robot_keyframe;
    v.T_b_s = cloud_s.T_robot_keyframe;
    if (v.result.reason == LinkReason::accepted) {
      verified.push_back(std::move(v));
    } else if (v.result.matches > best_refused) {  // what the refusal will say, if it is one
      best_refused = v.result.matches;
      link.reason = v.result.reason;
      link.keyframe_a = v.keyframe_r;
      link.keyframe_b = v.keyframe_s;
      link.inliers = static_cast<std::uint32_t>(v.result.inliers);
    }
  }
  return verified;
}

// The largest set of pairs that agree with one of them.
std::vector<const Verified*> largest_agreement(const std::vector<Verified>& verified) {
  std::vector<const Verified*> best;
  for (const Verified& v : verified) {
    const Pose T = between_references(v);
    std::vector<const Verified*> support;
    for (const Verified& other : verified)
      if (agree(T, between_references(other), other.T_b_s.t)) support.push_back(&other);
    if (support.size() > best.size()) best = support;
  }
  return best;
}

// The link from the pairs that agree.
void conclude(const std::vector<const Verified*>& best, const VerifyConfig& config, LinkRecord& link) {
  link.supporting_pairs = static_cast<std::uint32_t>(best.size());
  const Verified& top = **std::max_element(best.begin(), best.end(), [](const Verified* x, const Verified* y) {
    return x->result.inliers < y->result.inliers;
  });
  link.keyframe_a = top.keyframe_r;
  link.keyframe_b = top.keyframe_s;
  link.ratio_e4 = static_cast<std::uint32_t>(std::lround(top.result.ratio * 10000));
  if (best.size() < static_cast<std::size_t>(config.min_supporting_pairs) &&
      top.result.inliers < config.strong_inliers) {
    link.reason = LinkReason::inconsistent;
    link.inliers = static_cast<std::uint32_t>(top.result.inliers);
    return;
  }
  Pose T_a_b = between_references(top);
  int inliers = 0;
  const double rms = fit_common(best, T_a_b, inliers);
  link.reason = LinkReason::accepted;
  link.inliers = static_cast<std::uint32_t>(inliers);
  link.error_um = static_cast<std::int32_t>(std::lround(rms * 1e6));
  link.T_a_b = quantize(T_a_b);
}

}  // namespace

std::optional<LinkRecord> verify_robots(const KeyframeSource& a, const KeyframeSource& b, std::vector<CloudPair> pairs,
                                        const VerifyConfig& config, const std::function<bool()>& stop) {
  LinkRecord link;
  link.a = a.robot;
  link.b = b.robot;
  link.keyframes_a = static_cast<std::uint32_t>(a.count);
  link.keyframes_b = static_cast<std::uint32_t>(b.count);
  link.reason = LinkReason::too_few_matches;
  const auto verified = verify_candidates(a, b, choose(std::move(pairs)), config, stop, link);
  if (!verified) return std::nullopt;
  const auto best = largest_agreement(*verified);
  if (!best.empty()) conclude(best, config, link);
  return link;
}

LinkRecord verify_robots(const RobotId& a, std::span<const KeyframeRecord> keyframes_a, const RobotId& b,
                         std::span<const KeyframeRecord> keyframes_b, const VerifyConfig& config) {
  const auto source = [](const RobotId& robot, std::span<const KeyframeRecord> keyframes) {
    return KeyframeSource{robot, keyframes.size(), [keyframes](std::size_t i) { return keyframes[i]; }};
  };
  const KeyframeSource of_a = source(a, keyframes_a), of_b = source(b, keyframes_b);
  const auto never = [] { return false; };
  std::optional<std::vector<CloudPair>> pairs;
  if (config.find_pairs == FindPairs::all_pairs) {
    pairs = match_all_pairs(of_a, of_b, never);
  } else {
    PlaceIndex index({});
    for (std::uint32_t i = 0; i < keyframes_a.size(); ++i)
      index.insert({a, 0, i}, keyframes_a[i].descriptor_kind, binary_features(keyframes_a[i]));
    pairs = ask_index(index, of_b, never);
  }
  return *verify_robots(of_a, of_b, std::move(*pairs), config, never);
}

}  // namespace onemap::mapping
