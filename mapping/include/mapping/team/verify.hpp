#pragma once
#include <span>

#include "mapping/team/records.hpp"

namespace onemap::mapping {

struct VerifyConfig {
  int min_matches = 30;          // mutual nearest neighbours of a pair of clouds
  int min_inliers = 25;          // after the 3D RANSAC
  int min_supporting_pairs = 2;  // that agree, unless one pair alone has
  int strong_inliers = 60;       // so many inliers
  float max_ratio = 0.9f;        // of the descriptor matcher
  std::uint64_t seed = 1;
};

// One pair of clouds r of robot a, s of robot b (the paper, section 4): matches, fundamental matrix, depth check, 3D
// RANSAC, ICP on the depth grids.
struct PairResult {
  LinkReason reason = LinkReason::too_few_matches;
  int matches = 0, inliers = 0;
  double ratio = 0;    // quality: inliers / min(features of r, features of s)
  double error_m = 0;  // ICP's rms
  Pose T_r_s;
};
PairResult verify_pair(const KeyframeRecord& r, const KeyframeRecord& s, const VerifyConfig& config);

// All pairs of two robots' keyframes, and from the pairs that agree one transform T_a_b (eq. 9-11). reason says why
// not.
LinkRecord verify_robots(const RobotId& a, std::span<const KeyframeRecord> keyframes_a, const RobotId& b,
                         std::span<const KeyframeRecord> keyframes_b, const VerifyConfig& config);

}  // namespace onemap::mapping
