#include "focal_watch.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::mapping {

namespace {

// Between two keyframes: enough of a turn that some of what lay beside is ahead, and still much to be seen in both.
constexpr double kLeastCosine = 0.86, kMostCosine = 0.985, kBestCosine = 0.93;  // 31, 10 and 22 degrees
constexpr double kFarthest_m = 1.0;
constexpr std::size_t kLeastMatches = 25;

MatchConfig strict() {
  MatchConfig config;
  config.max_ratio = 0.8F;
  return config;
}

FundamentalConfig fundamental_config(const hal::Intrinsics& k, std::uint64_t seed) {
  FundamentalConfig config;
  config.threshold = 2.0 / (0.5 * (k.fx + k.fy));
  config.seed = seed;
  return config;
}

}  // namespace

FocalWatch::FocalWatch(const hal::Intrinsics& k, const hal::DepthNoise& noise, std::size_t max_features,
                       std::uint64_t seed)
    : matcher_(strict(), max_features),
      fundamental_(fundamental_config(k, seed), max_features),
      check_(max_features, noise) {
  ray_a_.reserve(max_features);
  ray_b_.reserve(max_features);
  inlier_.reserve(max_features);
  point_a_.reserve(max_features);
  point_b_.reserve(max_features);
}

const MapKeyframe* FocalWatch::turned_from(const KeyframeMap& map) const {
  const MapKeyframe& reference = map.reference();
  const MapKeyframe* best = nullptr;
  double least = 1;
  for (std::size_t slot = 0; slot < map.landmarks().keyframe_capacity(); ++slot) {
    const MapKeyframe& other = map.landmarks().keyframe(slot);
    if (!other.used || slot == map.reference_slot()) continue;
    const Pose T = other.T_camera_robot * reference.T_camera_robot.inverse();
    const double cosine = rotation_cosine(T.R), off = std::abs(cosine - kBestCosine);
    if (cosine < kLeastCosine || cosine > kMostCosine || T.t.squaredNorm() > kFarthest_m * kFarthest_m) continue;
    if (off >= least) continue;
    least = off;
    best = &other;
  }
  return best;
}

void FocalWatch::look(const KeyframeMap& map) {
  const MapKeyframe* other = turned_from(map);
  if (other == nullptr) return;
  const FeatureFrame &a = map.reference().features, &b = other->features;
  const auto matches = matcher_.match(a.set, b.set);
  if (matches.size() < kLeastMatches) return;
  ray_a_.clear();
  ray_b_.clear();
  for (const Match& m : matches) {
    ray_a_.push_back(a.ray[m.a]);
    ray_b_.push_back(b.ray[m.b]);
  }
  inlier_.assign(matches.size(), 0);
  Matrix3d F;
  if (!fundamental_.estimate(ray_b_, ray_a_, inlier_, F).ok()) return;
  point_a_.clear();
  point_b_.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!inlier_[i] || !a.has_depth(matches[i].a) || !b.has_depth(matches[i].b)) continue;
    point_a_.push_back(a.point[matches[i].a]);
    point_b_.push_back(b.point[matches[i].b]);
  }
  check_.add(point_a_, point_b_);
}

}  // namespace onemap::mapping
