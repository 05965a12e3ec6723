#pragma once
#include <cstdint>
#include <optional>

#include "depth_lead.hpp"
#include "front_end.hpp"
#include "hal/frame.hpp"
#include "keyframe_map.hpp"
#include "landmark_fit.hpp"
#include "mapping/local/icp.hpp"
#include "mapping/local/match_picture.hpp"
#include "mapping/local/step.hpp"
#include "mapping/local/track_reason.hpp"
#include "mapping/local/two_view.hpp"
#include "motion.hpp"
#include "motion_gate.hpp"

namespace onemap::mapping {

// Where a frame was placed, or why it was not.
struct Placed {
  TrackReason reason = TrackReason::ok;
  Pose T_camera_robot;             // when ok()
  int matches = 0, inliers = 0;    // of the last image that it was compared with
  std::optional<PosePrior> depth;  // what depth says of the pose, when depth led

  bool ok() const { return reason == TrackReason::ok || reason == TrackReason::first_frame; }
};

struct TrackerConfig {
  int max_features = 500;
  std::uint64_t seed = 1;
  hal::DepthNoise noise;
};

// Where is the camera? A frame is placed by the frame before it, by the reference keyframe, or, when the camera is
// lost, by earlier keyframes; where these have few features, by depth. Memory is taken in the constructor.
class Tracker {
 public:
  // spare: an Observed with the memory that frames need (FrontEnd::make_observed()).
  Tracker(const TrackerConfig& config, const hal::Intrinsics& intrinsics, Observed spare);

  TrackState state() const { return state_; }
  // Notes in seen's features which landmarks they are, and may change the map's reference.
  Placed locate(Observed& seen, KeyframeMap& map, const StepHook& begin);
  // How the camera moved between the two images of a frame that comes next, if it goes on as it did. Nothing: it did
  // not, or it is not known.
  std::optional<Pose> between_images(const hal::FrameView& frame) const {
    return motion_.between(frame.depth_time, frame.colour_time);
  }
  // The same once it is known where it came to. Before follow().
  std::optional<Pose> between_images(const Observed& seen, const Pose& T_camera_robot) const;
  // Before the first frame is placed: how the camera moves, from two frames.
  void see_motion(const Observed& first, const Observed& second, const StepHook& begin);
  // What became of the frame: it was placed (seen is then another's, for the next frame), was lost, or is not looked
  // at.
  void follow(Observed& seen, FrameTime time, const Pose& T_camera_robot);
  void lose();
  void skip() { compared_ = {}; }

  // seen: as the last call left it. Valid until the next call.
  MatchPicture last_matches(const Observed& seen, const KeyframeMap& map) const;
  std::size_t bytes() const { return two_view_.bytes(); }

 private:
  // The image that the frame was last compared with.
  struct Compared {
    enum class With : std::uint8_t { nothing, previous, keyframe } with = With::nothing;
    std::size_t slot = 0;
    FrameTime time{};
  };
  Placed first(const Observed& seen, const KeyframeMap& map) const;
  Placed by_known_images(Observed& seen, KeyframeMap& map, const StepHook& begin);
  TrackReason relocalise(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed);
  TrackReason by_previous(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed);
  TrackReason by_keyframe(std::size_t slot, Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed);
  TrackReason by_image(const FeatureFrame& other, const Pose& T_other_robot, Observed& seen, KeyframeMap& map,
                       const StepHook& begin, Placed& placed);
  void lead_where_colour_is_poor(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed);
  std::optional<PosePrior> align_depth(const Observed& seen, const KeyframeMap& map, const Pose& T_camera_robot) const;

  TwoView two_view_;
  Icp icp_;
  LandmarkFit fit_;
  MotionGate jump_gate_;
  TrackState state_ = TrackState::starting;
  Observed previous_;  // the last placed frame
  FrameTime previous_time_{};
  Pose T_previous_robot_;
  Motion motion_;
  FrameTime all_seen_{};                 // of the last frame for which all six directions were seen
  std::size_t relocalisation_next_ = 0;  // slot
  Compared compared_;
  bool placed_ = false;  // the frame that was compared: previous_ is it then
};

}  // namespace onemap::mapping
