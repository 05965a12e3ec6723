#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/frame.hpp"
#include "landmark_map.hpp"
#include "motion_gate.hpp"
#include "reference_cloud.hpp"
#include "window_adjuster.hpp"

namespace onemap::mapping {

struct KeyframeMapConfig {
  int max_keyframes = 200;
  int max_features = 500;
  double keyframe_translation_m = 0.10;  // motion since the reference that makes a new keyframe
  double keyframe_rotation_deg = 8.0;
};

// What the robot remembers of where it was: keyframes and landmarks, the reference among them with its cloud and its
// neighbourhood, and the window of the last keyframes, whose poses bundle adjustment still moves. Memory is taken in
// the constructor.
class KeyframeMap {
 public:
  KeyframeMap(const KeyframeMapConfig& config, const hal::Intrinsics& intrinsics, const hal::DepthNoise& noise = {});

  bool empty() const { return made_ == 0; }
  std::uint64_t made() const { return made_; }  // keyframes, ever
  LandmarkMap& landmarks() { return map_; }
  const LandmarkMap& landmarks() const { return map_; }

  // The keyframe that frames are placed by; only when not empty.
  std::size_t reference_slot() const { return reference_; }
  const MapKeyframe& reference() const { return map_.keyframe(reference_); }
  const OrganizedCloud& reference_cloud() const { return cloud_.cloud(); }
  void use_reference(std::size_t slot);
  // While empty: a frame that may become the first keyframe; reference_cloud() is its own until the next call.
  void look(std::span<const std::uint16_t> depth, const std::optional<Pose>& T_colour_depth) {
    cloud_.look(depth, T_colour_depth);
  }
  // The landmarks that the reference and the keyframes around it see.
  std::span<const std::int32_t> near() const { return near_landmarks_; }

  // A frame was placed (led: by depth, where colour had little to say): the keyframe of the neighbourhood that shares
  // most landmarks with it becomes the reference. Whether the frame should become a keyframe itself.
  bool follow(const FeatureFrame& features, const Pose& T_camera_robot, int inliers, bool led = false);

  // The frame becomes a keyframe and the reference: new landmarks, and bundle adjustment of the window, after which the
  // reference has its pose and the features know their landmarks. depth: what holds its pose beside its landmarks. The
  // slot of the keyframe that left the window.
  std::optional<std::size_t> add(const hal::FrameView& frame, const Pose& T_camera_robot, FeatureFrame& features,
                                 const std::optional<PosePrior>& depth = std::nullopt,
                                 const std::optional<Pose>& T_colour_depth = {});
  std::optional<std::size_t> seal_oldest();  // of the window; none when it is empty
  // The oldest of the window if it was made before `then`: what others wait for does not wait for motion.
  std::optional<std::size_t> seal_older(FrameTime then);
  // The anchors of the keyframes around the reference (and of the one that it was led from), each once. Valid until the
  // next add().
  std::span<const SubmapAnchor> near_anchors();
  void hang_reference(const std::optional<SubmapAnchor>& anchor);  // on that one; none: it is an anchor itself
  // The anchors among the keyframes of the window, which have moved with it. Valid until the next call.
  std::span<const SubmapAnchor> moved_anchors();
  // The sealed keyframe that waits longest, once; nullptr when none waits.
  const MapKeyframe* take_sealed() { return map_.take_sealed(); }

  std::size_t bytes() const { return map_.bytes() + adjuster_.bytes() + cloud_.bytes(); }

 private:
  static constexpr std::size_t kMaxNearLandmarks = 6000, kMaxWindowObservations = 16000, kNearKeyframes = 10;
  void choose_reference(const FeatureFrame& features);
  void gather_near();
  bool wants(const FeatureFrame& features, const Pose& T_camera_robot, int inliers, bool led) const;
  MapKeyframe& take_keyframe(FeatureFrame& features, std::size_t& slot);
  void link_landmarks(MapKeyframe& keyframe);
  std::span<const std::size_t> window() const { return {window_.data(), window_size_}; }

  MotionGate gate_;
  double focal_px_;
  LandmarkMap map_;
  WindowAdjuster adjuster_;
  ReferenceCloud cloud_;
  std::uint64_t made_ = 0;
  std::uint32_t frames_since_keyframe_ = 0;
  std::size_t reference_ = 0;                  // slot
  std::size_t led_from_ = 0;                   // slot of the reference before, when the reference was led by depth
  std::array<std::size_t, kWindow> window_{};  // slots, oldest first
  std::size_t window_size_ = 0;
  std::array<std::size_t, kNearKeyframes> near_keyframes_{};
  std::size_t near_keyframe_count_ = 0;
  std::vector<std::int32_t> near_landmarks_;
  std::array<SubmapAnchor, std::max(kNearKeyframes + 1, kWindow)> anchors_;  // answers
};

}  // namespace onemap::mapping
