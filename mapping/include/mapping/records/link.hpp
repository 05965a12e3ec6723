#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// Why a pair is not linked, of its most promising two clouds, and after the slash what LinkRecord::measured then is.
enum class LinkReason : std::uint8_t {
  accepted = 0,
  too_few_matches,     // features that match / so many
  fundamental_failed,  // no fundamental matrix / features that match
  depth_incoherent,    // too few of them have depths that agree / features that match
  ransac_failed,       // no rigid motion / matches that agree with the best
  icp_failed,          // the depth grids do not fit / their rms error, micrometres
  inconsistent,        // too few pairs of clouds agree / so many
  little_overlap,      // of the depth grids / the share that fits, in 1/10000
  seen_through,        // one lies where the other saw free space / the share that does not, in 1/10000
  another_place,       // other pairs agree on another place / so many
  not_seen_again       // of the clouds that would show one place / the share that does, in 1/10000
};
inline constexpr LinkReason kLastLinkReason = LinkReason::not_seen_again;

inline constexpr std::uint32_t kMaxSupportingPairs = 1024, kMaxInliersOfPair = 1000;
inline constexpr std::size_t kMaxLinkPairs = 256;

// Two keyframes that were found to show one place.
struct LinkPair {
  std::uint32_t keyframe_a = 0, keyframe_b = 0;
  std::uint32_t inliers = 0;  // matched features that agree; 1 to 1000
  QuantizedPose T_a_b;        // keyframe b in the frame of keyframe a
  bool operator==(const LinkPair&) const = default;
};

// A verified (or refused) relation of two chains' maps: the paper's quality ratio and eq. (11). One of the two writes
// it, about itself and the other: the lower one, and the higher one when the lower is gone or an earlier life. Or, with
// a = b and its own life, the places that one robot came back to.
struct LinkRecord {                                // lane poses
  RobotId a, b;                                    // a <= b; of one robot's two lives a is the earlier one
  std::uint64_t incarnation_other = 0;             // which life of the other one; the author's is that of its log
  std::uint32_t keyframes_a = 0, keyframes_b = 0;  // so many keyframes of each were looked at
  std::uint32_t keyframe_a = 0, keyframe_b = 0;    // the best pair of clouds r, s
  LinkReason reason = LinkReason::accepted;
  std::uint32_t measured = 0;          // see LinkReason; 0 when accepted
  std::uint32_t supporting_pairs = 0;  // pairs of clouds that agree with the transform; at most 1024
  std::uint32_t inliers = 0;           // matched features that agree, over all supporting pairs; 1000 of each at most
  std::uint32_t ratio_e4 = 0;          // quality ratio of the best pair: inliers / features, times 10000
  std::int32_t error_um = 0;           // rms of the supporting pairs' residual
  QuantizedPose T_a_b;                 // ref_a T ref_b, if both robots' odometry were right; one life: the identity
  // Every verified pair, also those that do not support T_a_b: odometry drifts, and the pose graph judges. Sorted by
  // (keyframe_a, keyframe_b), each once; of one life keyframe_a < keyframe_b. At most 256; none unless accepted.
  std::vector<LinkPair> pairs;
};

// Of one life the places that it came back to must be two each: what decode_link() cannot know.
Status check_own_loops(const LinkRecord& record);

std::vector<std::uint8_t> encode(const LinkRecord& record);
Result<LinkRecord> decode_link(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
