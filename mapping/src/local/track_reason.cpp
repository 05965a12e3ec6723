#include "mapping/local/track_reason.hpp"

namespace onemap::mapping {

std::string_view to_string(TrackReason reason) {
  switch (reason) {
    case TrackReason::ok:
      return "ok";
    case TrackReason::first_frame:
      return "first frame";
    case TrackReason::too_few_features:
      return "too few features";
    case TrackReason::too_few_matches:
      return "too few matches";
    case TrackReason::fundamental_failed:
      return "fundamental matrix failed";
    case TrackReason::depth_incoherent:
      return "too few coherent depths";
    case TrackReason::ransac_failed:
      return "3D RANSAC failed";
    case TrackReason::icp_failed:
      return "ICP failed";
    case TrackReason::inconsistent_motion:
      return "inconsistent motion";
    case TrackReason::time_not_increasing:
      return "time not increasing";
    case TrackReason::direction_unseen:
      return "a direction that neither colour nor depth sees";
    case TrackReason::count:
      return "count";
  }
  return "unknown";
}

}  // namespace onemap::mapping
