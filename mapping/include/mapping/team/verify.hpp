#pragma once
#include <functional>
#include <optional>
#include <span>

#include "mapping/records/keyframe.hpp"
#include "mapping/records/link.hpp"

namespace onemap::mapping {

struct VerifyConfig {
  int min_matches = 30;          // mutual nearest neighbours of a pair of clouds
  int min_inliers = 25;          // after the 3D RANSAC
  int min_supporting_pairs = 2;  // that agree, unless one pair alone has
  int strong_inliers = 60;       // so many inliers
  float max_ratio = 0.9f;        // of the descriptor matcher
  std::uint64_t seed = 1;
};

// One robot's keyframes, each decoded only while it is looked at: load(i) for i < count gives the same record every
// time.
struct KeyframeSource {
  RobotId robot;
  std::size_t count = 0;
  std::function<KeyframeRecord(std::size_t)> load;
};

// All pairs of two robots' keyframes, and from the pairs that agree one transform T_a_b (eq. 9-11). reason says why
// not. Robot a's id is the lower; incarnation_other is the caller's to write. Asks stop() between pairs of clouds and
// gives up without a result when it says true.
std::optional<LinkRecord> verify_robots(const KeyframeSource& a, const KeyframeSource& b, const VerifyConfig& config,
                                        const std::function<bool()>& stop);

// The same from records at hand, to the end.
LinkRecord verify_robots(const RobotId& a, std::span<const KeyframeRecord> keyframes_a, const RobotId& b,
                         std::span<const KeyframeRecord> keyframes_b, const VerifyConfig& config);

}  // namespace onemap::mapping
