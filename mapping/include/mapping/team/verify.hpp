#pragma once
#include <functional>
#include <optional>
#include <span>

#include "mapping/records/keyframe.hpp"
#include "mapping/records/link.hpp"
#include "mapping/team/candidates.hpp"

namespace onemap::mapping {

struct VerifyConfig {
  int min_matches = 30;          // mutual nearest neighbours of a pair of clouds
  int min_inliers = 25;          // after the 3D RANSAC
  int min_supporting_pairs = 2;  // that agree, unless one pair alone has
  int strong_inliers = 60;       // so many inliers
  float max_ratio = 0.95f;       // of the descriptor matcher, by Hamming distance
  FindPairs find_pairs = FindPairs::by_index;
  std::uint64_t seed = 1;
};

// Pairs of two robots' keyframes looked at closely, the chosen ones of `pairs`, and from those that agree one transform
// T_a_b (eq. 9-11); pairs that lie side by side by that and do not show one place refute it (inconsistent): places
// that look alike do not from everywhere. reason says why not. Robot a's id is the lower; incarnation_other is the
// caller's to write. Asks stop() between pairs of clouds and gives up without a result when it says true.
std::optional<LinkRecord> verify_robots(const KeyframeSource& a, const KeyframeSource& b, std::vector<CloudPair> pairs,
                                        const VerifyConfig& config, const std::function<bool()>& stop);

// The same from records at hand, to the end; the pairs are found as the configuration says, by an index of a's.
LinkRecord verify_robots(const RobotId& a, std::span<const KeyframeRecord> keyframes_a, const RobotId& b,
                         std::span<const KeyframeRecord> keyframes_b, const VerifyConfig& config);

}  // namespace onemap::mapping
