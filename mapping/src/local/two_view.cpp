#include "mapping/local/two_view.hpp"

#include <utility>

namespace onemap::mapping {

TwoView::TwoView(const TwoViewConfig& config, std::size_t max_features)
    : config_(config),
      matcher_(config.match, max_features),
      fundamental_(config.fundamental, max_features),
      rigid_(config.rigid, max_features) {
  if (config.look_up == LookUp::b_in_a) turned_.reserve(max_features);
  kept_.reserve(max_features);
  ray_b_.reserve(max_features);
  ray_a_.reserve(max_features);
  point_b_.reserve(max_features);
  point_a_.reserve(max_features);
  pair_of_.reserve(max_features);
  coherent_.reserve(max_features);
}

const TwoViewResult& TwoView::relate(const FeatureCloud& a, const FeatureCloud& b, const StepHook& begin) {
  result_ = {};
  result_.reason = find(a, b, begin);
  return result_;
}

TwoViewReason TwoView::find(const FeatureCloud& a, const FeatureCloud& b, const StepHook& begin) {
  begin(Step::match);
  match(a, b);
  if (result_.matches.size() < static_cast<std::size_t>(config_.min_matches)) return TwoViewReason::too_few_matches;
  begin(Step::fundamental);
  if (!fits_fundamental(a, b)) return TwoViewReason::fundamental_failed;
  begin(Step::ransac);
  pair_points(a, b);
  if (point_a_.size() < static_cast<std::size_t>(config_.min_coherent)) return TwoViewReason::depth_incoherent;
  return fits_rigid() ? TwoViewReason::ok : TwoViewReason::ransac_failed;
}

// Mutual nearest neighbours (the cross check).
void TwoView::match(const FeatureCloud& a, const FeatureCloud& b) {
  if (config_.look_up == LookUp::a_in_b) {
    result_.matches = matcher_.match(a.set, b.set);
  } else {
    const auto found = matcher_.match(b.set, a.set);
    turned_.assign(found.begin(), found.end());
    for (Match& m : turned_) std::swap(m.a, m.b);
    result_.matches = turned_;
  }
  kept_.assign(result_.matches.size(), 0);
  result_.kept = kept_;
}

// Eq. (6), with b as the first of its two images.
bool TwoView::fits_fundamental(const FeatureCloud& a, const FeatureCloud& b) {
  ray_b_.clear();
  ray_a_.clear();
  for (const Match& m : result_.matches) {
    ray_b_.push_back(b.ray[m.b]);
    ray_a_.push_back(a.ray[m.a]);
  }
  Matrix3d F;
  return fundamental_.estimate(ray_b_, ray_a_, kept_, F).ok();
}

// The points of the matches that fit F; such a match is kept no longer until the 3D RANSAC says so.
void TwoView::pair_points(const FeatureCloud& a, const FeatureCloud& b) {
  point_b_.clear();
  point_a_.clear();
  pair_of_.clear();
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (std::exchange(kept_[i], std::uint8_t{0}) == 0) continue;
    const Match& m = result_.matches[i];
    if (!b.has_depth(m.b) || !a.has_depth(m.a)) continue;
    point_b_.push_back(b.point[m.b]);
    point_a_.push_back(a.point[m.a]);
    pair_of_.push_back(static_cast<std::uint16_t>(i));
  }
}

bool TwoView::fits_rigid() {
  coherent_.assign(point_a_.size(), 0);
  const RansacResult found = rigid_.estimate(point_b_, point_a_, coherent_, result_.T_b_a);
  result_.inliers = found.inliers;
  if (!found.ok()) return false;
  for (std::size_t i = 0; i < coherent_.size(); ++i) kept_[pair_of_[i]] = coherent_[i];
  return true;
}

std::size_t TwoView::bytes() const {
  return kept_.capacity() *
             (2 * sizeof(std::uint8_t) + sizeof(std::uint16_t) + 2 * sizeof(Eigen::Vector2d) + 2 * sizeof(Vector3d)) +
         turned_.capacity() * sizeof(Match);
}

}  // namespace onemap::mapping
