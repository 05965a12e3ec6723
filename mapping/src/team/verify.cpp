#include "mapping/team/verify.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mapping/local/rigid.hpp"
#include "team/verify_clouds.hpp"

namespace onemap::mapping {

namespace {

constexpr double kAhead_m = 2, kApart_m = 3;  // what two clouds look at, and how far apart they and that may be
constexpr std::size_t kMorePairs = 24;
// Of those that are this close so many must show one place, if there are enough to tell. Simulated corridors whose
// doors look alike: 0.04 to 0.75 where the doors were others, 0.96 and more where they were the same.
constexpr double kShareClose = 0.85, kClose_m = 1.5;
constexpr std::size_t kFewestClose = 6;
// Pairs that put the other robot elsewhere, by more than odometry may drift between them and the ones they contradict.
// As many as this share of these: doors that look alike agree with each other in groups, one for each way to lay one
// row of doors on the other.
constexpr double kElsewhere_m = 0.5, kDriftShare = 0.02, kShareElsewhere = 0.5;

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
// of the refused was refused. False when stopped.
bool verify_candidates(const KeyframeSource& a, const KeyframeSource& b, const std::vector<CloudPair>& chosen,
                       const VerifyConfig& config, const std::function<bool()>& stop, std::vector<Verified>& verified,
                       LinkRecord& link) {
  int best_refused = -1;
  for (const CloudPair& c : chosen) {
    if (stop()) return false;
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
      link.measured = v.result.measured;
      link.keyframe_a = v.keyframe_r;
      link.keyframe_b = v.keyframe_s;
      link.inliers = static_cast<std::uint32_t>(v.result.inliers);
    }
  }
  return true;
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

// What the pose graph gets: every pair that was verified, sorted.
std::vector<LinkPair> pairs_of(const std::vector<Verified>& verified) {
  std::vector<LinkPair> out;
  out.reserve(verified.size());
  for (const Verified& v : verified)
    out.push_back({v.keyframe_r, v.keyframe_s, static_cast<std::uint32_t>(v.result.inliers), quantize(v.result.T_r_s)});
  const auto ends = [](const LinkPair& pair) { return std::pair(pair.keyframe_a, pair.keyframe_b); };
  std::ranges::stable_sort(out, {}, ends);
  const auto same = [&](const LinkPair& x, const LinkPair& y) { return ends(x) == ends(y); };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

const Verified& strongest(const std::vector<const Verified*>& pairs) {
  return **std::ranges::max_element(pairs, {}, [](const Verified* v) { return v->result.inliers; });
}

bool enough(const std::vector<const Verified*>& pairs, const VerifyConfig& config) {
  return pairs.size() >= static_cast<std::size_t>(config.min_supporting_pairs) ||
         (!pairs.empty() && strongest(pairs).result.inliers >= config.strong_inliers);
}

// How many agree on another place than the best ones do.
std::size_t count_elsewhere(const std::vector<Verified>& verified, const std::vector<const Verified*>& best) {
  const Verified& top = strongest(best);
  const Pose T_b_a = between_references(top).inverse();
  std::vector<Verified> elsewhere;
  for (const Verified& v : verified) {
    const Vector3d off = T_b_a * (between_references(v) * v.T_b_s.t) - v.T_b_s.t;
    const double way_m = (v.T_a_r.t - top.T_a_r.t).norm() + (v.T_b_s.t - top.T_b_s.t).norm();
    if (off.norm() > kElsewhere_m + kDriftShare * way_m) elsewhere.push_back(v);
  }
  return largest_agreement(elsewhere).size();
}

// Once it is known how the two maps lie: the pairs of clouds that look at one place from nearby and were not looked at
// yet, the nearest first. Where features are few the index does not see them.
struct SideBySide {
  std::vector<CloudPair> close, others;
};
SideBySide side_by_side(const KeyframeSource& a, const KeyframeSource& b, const Pose& T_a_b,
                        const std::vector<CloudPair>& looked_at) {
  const Vector3d ahead(0, 0, kAhead_m);
  const auto poses = [](const KeyframeSource& source) {
    std::vector<std::optional<Pose>> out(source.count);  // nothing: without features there is nothing to compare
    for (std::size_t i = 0; i < source.count; ++i)
      if (const KeyframeRecord keyframe = source.load(i); !keyframe.features.empty())
        out[i] = from_quantized(keyframe.T_robot_keyframe);
    return out;
  };
  const std::vector<std::optional<Pose>> in_a = poses(a), in_b = poses(b);
  std::vector<std::pair<double, CloudPair>> near;
  for (std::size_t r = 0; r < in_a.size(); ++r)
    for (std::size_t s = 0; s < in_b.size(); ++s) {
      if (!in_a[r] || !in_b[s]) continue;
      const Pose T_r_s = in_a[r]->inverse() * T_a_b * *in_b[s];
      const double apart = (T_r_s * ahead - ahead).norm() + T_r_s.t.norm();
      const auto same = [&](const CloudPair& pair) { return pair.r == r && pair.s == s; };
      if (apart < kApart_m && std::ranges::none_of(looked_at, same)) near.push_back({apart, {r, s, 0}});
    }
  std::ranges::stable_sort(near, {}, &std::pair<double, CloudPair>::first);
  if (near.size() > kMorePairs) near.resize(kMorePairs);
  SideBySide out;
  for (const auto& [apart, pair] : near) (apart < kClose_m ? out.close : out.others).push_back(pair);
  return out;
}

// The link from the pairs that agree.
void conclude(const std::vector<const Verified*>& best, const VerifyConfig& config, LinkRecord& link) {
  link.supporting_pairs = static_cast<std::uint32_t>(best.size());
  const Verified& top = strongest(best);
  link.keyframe_a = top.keyframe_r;
  link.keyframe_b = top.keyframe_s;
  link.ratio_e4 = static_cast<std::uint32_t>(std::lround(top.result.ratio * 10000));
  if (!enough(best, config)) {
    link.reason = LinkReason::inconsistent;
    link.measured = link.supporting_pairs;
    link.inliers = static_cast<std::uint32_t>(top.result.inliers);
    return;
  }
  Pose T_a_b = between_references(top);
  int inliers = 0;
  const double rms = fit_common(best, T_a_b, inliers);
  link.reason = LinkReason::accepted;
  link.measured = 0;
  link.inliers = static_cast<std::uint32_t>(inliers);
  link.error_um = static_cast<std::int32_t>(std::lround(rms * 1e6));
  link.T_a_b = quantize(T_a_b);
}

void refuse(LinkRecord& link, LinkReason reason, double measured) {
  link.reason = reason;
  link.measured = static_cast<std::uint32_t>(std::lround(measured));
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
  std::vector<Verified> verified;
  const std::vector<CloudPair> chosen = choose(std::move(pairs));
  if (!verify_candidates(a, b, chosen, config, stop, verified, link)) return std::nullopt;
  SideBySide near;
  std::size_t elsewhere = 0;
  bool contested = false;
  const std::size_t before = verified.size();
  if (const auto first = largest_agreement(verified); enough(first, config)) {
    near = side_by_side(a, b, between_references(strongest(first)), chosen);
    elsewhere = count_elsewhere(verified, first);
    contested = static_cast<double>(elsewhere) > kShareElsewhere * static_cast<double>(first.size());
  }
  if (!verify_candidates(a, b, near.close, config, stop, verified, link)) return std::nullopt;
  const std::size_t after = verified.size();
  if (!verify_candidates(a, b, near.others, config, stop, verified, link)) return std::nullopt;
  const auto best = largest_agreement(verified);
  if (!best.empty()) conclude(best, config, link);
  const auto among_close = [&](const Verified* v) {
    return v >= verified.data() + before && v < verified.data() + after;
  };
  const auto shown = static_cast<double>(std::ranges::count_if(best, among_close));
  const auto close = static_cast<double>(near.close.size());
  const bool refuted = near.close.size() >= kFewestClose && shown < kShareClose * close;
  if (link.reason == LinkReason::accepted && contested)
    refuse(link, LinkReason::another_place, static_cast<double>(elsewhere));
  if (link.reason == LinkReason::accepted && refuted) refuse(link, LinkReason::not_seen_again, 1e4 * shown / close);
  if (link.reason == LinkReason::accepted) link.pairs = pairs_of(verified);
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
