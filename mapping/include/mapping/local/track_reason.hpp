#pragma once
#include <cstdint>
#include <string_view>

namespace onemap::mapping {

enum class TrackState : std::uint8_t { starting, tracking, lost };

// Why a frame could not be placed (the first that failed, against the last keyframe tried). A frame whose time is not
// later than the last one's is refused and changes nothing: the camera is where it was.
enum class TrackReason : std::uint8_t {
  ok,
  first_frame,
  too_few_features,
  too_few_matches,
  fundamental_failed,
  depth_incoherent,
  ransac_failed,
  icp_failed,
  inconsistent_motion,
  time_not_increasing,
  direction_unseen,  // neither colour nor depth has told all six directions for too long
  count
};
std::string_view to_string(TrackReason reason);

}  // namespace onemap::mapping
