#pragma once
#include <cstdint>

#include "mapping/geometry.hpp"
#include "mapping/records/chain_id.hpp"

// What a pose graph is made of. Motions follow the house: T_a_b maps frame b to frame a, metres; errors and
// information are of (rotation vector rad, translation m) in that order, as small_motion takes them.
namespace onemap::mapping {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A keyframe of a chain: an anchor, or one that hangs on an anchor.
struct AnchorId {
  ChainId chain;
  std::uint32_t keyframe = 0;
  auto operator<=>(const AnchorId&) const = default;
};

// How sure a motion is, when rotation and translation are independent and equally sure on all axes. Both above 0.
Matrix6d information_of(double rotation_rad, double translation_m);

// An anchor and the odometry edge that leads to it. Odometry is never weighted down: who cannot vouch for a step begins
// a new chain.
struct ChainAnchor {
  std::uint32_t keyframe = 0;
  Pose T_previous_anchor;  // of the chain's first anchor: its pose in the chain's own frame
  // Inverse covariance of the step, in this anchor's frame; symmetric, positive definite. Not used of the first one.
  Matrix6d information = Matrix6d::Identity();
  // The box of what is anchored here, in the anchor's frame: how far a bend moves it decides whether the anchor moves.
  Vector3d box_centre_m = Vector3d::Zero();
  Vector3d box_half_m = Vector3d::Zero();
};

// One end of a link: the keyframe that was verified, the anchor that it hangs on (itself, or an earlier one), and
// where.
struct LinkEnd {
  ChainId chain;
  std::uint32_t keyframe = 0, anchor = 0;
  Pose T_anchor_keyframe;

  AnchorId keyframe_id() const { return {chain, keyframe}; }
  AnchorId anchor_id() const { return {chain, anchor}; }
};

// Which link: the two keyframes, a < b. A pair of keyframes has one link at most; a better one replaces it.
struct LinkId {
  AnchorId a, b;
  auto operator<=>(const LinkId&) const = default;
};

inline constexpr std::uint32_t kAllKeyframes = 0xFFFF'FFFF;

// A verified relative pose between keyframes of two chains, or of one (an own loop).
struct GraphLink {
  LinkEnd a, b;                // a.keyframe_id() < b.keyframe_id(); the anchors differ
  Pose T_a_b;                  // keyframe b in the frame of keyframe a
  std::uint32_t inliers = 75;  // matched features that agree, at least 1: they say how sure it is
  // The last keyframes of the two chains that who verified it had: that there is no link to later ones says nothing.
  std::uint32_t known_a = kAllKeyframes, known_b = kAllKeyframes;

  LinkId id() const { return {a.keyframe_id(), b.keyframe_id()}; }
};

}  // namespace onemap::mapping
