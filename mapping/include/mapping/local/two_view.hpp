#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/local/feature_cloud.hpp"
#include "mapping/local/fundamental.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/rigid.hpp"
#include "mapping/local/step.hpp"

namespace onemap::mapping {

// Whose features are looked up in the other image: the matcher's ratio test goes this way, and the matches come in the
// order of this image's features.
enum class LookUp : std::uint8_t { a_in_b, b_in_a };

struct TwoViewConfig {
  MatchConfig match;
  LookUp look_up = LookUp::a_in_b;
  FundamentalConfig fundamental;
  RigidConfig rigid;
  int min_matches = 15;   // mutual nearest neighbours
  int min_coherent = 12;  // matches that fit F and have a depth on both sides
};

enum class TwoViewReason : std::uint8_t { ok, too_few_matches, fundamental_failed, depth_incoherent, ransac_failed };

struct TwoViewResult {
  TwoViewReason reason = TwoViewReason::too_few_matches;
  Pose T_b_a;                          // when ok
  int inliers = 0;                     // of the 3D RANSAC, also when they were too few
  std::span<const Match> matches;      // feature a of the first image with feature b of the second
  std::span<const std::uint8_t> kept;  // of each match: 1 when it is an inlier of F and of the 3D RANSAC
};

// The motion between two images (the paper, section 3): features are matched to mutual nearest neighbours, wrong
// matches are found by the fundamental matrix (eq. 6), those that remain get their depths (eq. 5), and 3D RANSAC gives
// T_b_a. A robot's frames are related to each other by it, and the clouds of two robots. Memory is taken in the
// constructor. Deterministic.
class TwoView {
 public:
  TwoView(const TwoViewConfig& config, std::size_t max_features);
  TwoView(const TwoView&) = delete;  // the result looks into its own memory
  TwoView& operator=(const TwoView&) = delete;
  // The features of both have one kind and are at most max_features. The result is valid until the next call.
  const TwoViewResult& relate(const FeatureCloud& a, const FeatureCloud& b, const StepHook& begin = {});
  const TwoViewResult& last() const { return result_; }
  std::size_t bytes() const;

 private:
  TwoViewReason find(const FeatureCloud& a, const FeatureCloud& b, const StepHook& begin);
  void match(const FeatureCloud& a, const FeatureCloud& b);
  bool fits_fundamental(const FeatureCloud& a, const FeatureCloud& b);
  void pair_points(const FeatureCloud& a, const FeatureCloud& b);
  bool fits_rigid();

  TwoViewConfig config_;
  Matcher matcher_;
  FundamentalRansac fundamental_;
  RigidRansac rigid_;
  TwoViewResult result_;
  std::vector<Match> turned_;                   // for LookUp::b_in_a
  std::vector<std::uint8_t> kept_;              // of each match
  std::vector<Eigen::Vector2d> ray_b_, ray_a_;  // of each match
  std::vector<Vector3d> point_b_, point_a_;     // of each match with depths
  std::vector<std::uint16_t> pair_of_;          // whose match that is
  std::vector<std::uint8_t> coherent_;          // and whether 3D RANSAC kept it
};

}  // namespace onemap::mapping
