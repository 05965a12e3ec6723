#include "mapping/team/verify.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/local/match.hpp"
#include "mapping/local/rigid.hpp"
#include "team/verify_clouds.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kQuickFeatures = 128;  // for choosing the pairs that are worth a closer look
constexpr std::size_t kMaxCandidates = 32;   // pairs of clouds looked at closely for a pair of robots
constexpr int kQuickMatches = 8;             // a candidate has at least so many quick matches

// The first of a record's features are its strongest.
FeatureSet strongest(const KeyframeRecord& record) {
  FeatureSet some;
  some.kind = record.descriptor_kind;
  const std::size_t n = std::min(record.features.size(), kQuickFeatures);
  some.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    Keypoint k;
    k.laplacian = record.features[i].laplacian;
    some.keypoints.push_back(k);
    some.descriptors.push_back(record.features[i].descriptor);
  }
  return some;
}

std::vector<FeatureSet> strongest(const KeyframeSource& source) {
  std::vector<FeatureSet> out;
  out.reserve(source.count);
  for (std::size_t i = 0; i < source.count; ++i) out.push_back(strongest(source.load(i)));
  return out;
}

struct Candidate {
  int matches;
  std::size_t r, s;
};

// The best first, spread over the clouds: no cloud more than four times.
std::vector<Candidate> choose(std::vector<Candidate> all, std::size_t count_a, std::size_t count_b) {
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& x, const Candidate& y) { return x.matches > y.matches; });
  std::vector<int> times_r(count_a), times_s(count_b);
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

// The pairs of clouds with most matches among their strongest features; nothing when stopped.
std::optional<std::vector<Candidate>> candidates(const KeyframeSource& a, const KeyframeSource& b,
                                                 const std::function<bool()>& stop) {
  const std::vector<FeatureSet> quick_a = strongest(a), quick_b = strongest(b);
  MatchConfig config;
  config.max_ratio = 0.8f;
  Matcher matcher(config, kQuickFeatures);
  std::vector<Candidate> all;
  for (std::size_t r = 0; r < a.count; ++r) {
    if (stop()) return std::nullopt;
    for (std::size_t s = 0; s < b.count; ++s) {
      if (quick_a[r].kind != quick_b[s].kind) continue;
      const int n = static_cast<int>(matcher.match(quick_a[r], quick_b[s]).size());
      if (n >= kQuickMatches) all.push_back({n, r, s});
    }
  }
  return choose(std::move(all), a.count, b.count);
}

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
                                                       const VerifyConfig& config, const std::function<bool()>& stop,
                                                       LinkRecord& link) {
  const auto chosen = candidates(a, b, stop);
  if (!chosen) return std::nullopt;
  std::vector<Verified> verified;
  int best_refused = -1;
  for (const Candidate& c : *chosen) {
    if (stop()) return std::nullopt;
    const KeyframeRecord r = a.load(c.r), s = b.load(c.s);
    const Cloud cloud_r = unpack(r), cloud_s = unpack(s);
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

std::optional<LinkRecord> verify_robots(const KeyframeSource& a, const KeyframeSource& b, const VerifyConfig& config,
                                        const std::function<bool()>& stop) {
  LinkRecord link;
  link.a = a.robot;
  link.b = b.robot;
  link.keyframes_a = static_cast<std::uint32_t>(a.count);
  link.keyframes_b = static_cast<std::uint32_t>(b.count);
  link.reason = LinkReason::too_few_matches;
  const auto verified = verify_candidates(a, b, config, stop, link);
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
  return *verify_robots(source(a, keyframes_a), source(b, keyframes_b), config, [] { return false; });
}

}  // namespace onemap::mapping
