#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"
#include "mapping/local/focal_check.hpp"
#include "mapping/local/mapper_config.hpp"
#include "mapping/local/match_picture.hpp"
#include "mapping/local/step.hpp"
#include "mapping/local/submap_anchor.hpp"
#include "mapping/local/surface_counters.hpp"
#include "mapping/local/track_reason.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::mapping {

struct FrameReport {
  TrackState state = TrackState::starting;
  TrackReason reason = TrackReason::ok;
  bool keyframe_added = false;
  bool integrated = false;   // added to the voxel map
  bool relocalized = false;  // placed again after being lost
  int features = 0, matches = 0, inliers = 0;
  std::uint32_t reference_keyframe = 0;
  Pose T_robot_camera;  // current estimate; meaningful when placed()

  bool placed() const { return state == TrackState::tracking && reason == TrackReason::ok; }  // this very frame
};

struct LocalMapperCounters {
  std::uint64_t frames = 0, tracked = 0, lost = 0, times_lost = 0, relocalized = 0, integrated = 0;
  std::uint64_t keyframes = 0;          // ever made; those of the optimisation window are not handed out yet
  std::uint64_t keyframes_evicted = 0;  // of these, to make room; so keyframes - keyframes_evicted are in the map
  std::uint64_t keyframes_untaken = 0;  // of these, before anybody took them
  SurfaceCounters surface;
  std::size_t blocks = 0;  // of the pool that open submaps share, now in use
  std::array<std::uint64_t, static_cast<std::size_t>(TrackReason::count)> refused{};  // by reason

  std::uint64_t keyframes_in_map() const { return keyframes - keyframes_evicted; }
};

// One robot's tracking and map: the paper's section 3, made of five parts (front end, two-view, keyframe map, tracker,
// surface builder) that do not know it. process() runs the whole frame path on the caller's thread and
// does not allocate after the constructor. What leaves the robot (keyframes, poses) is taken in sealed form: a
// keyframe's pose may still move a little while it is in the optimisation window, so it is handed out when it leaves
// it.
class LocalMapper {
 public:
  // check(config, intrinsics) must have passed. noise: the camera's, by which its depth is weighed.
  LocalMapper(const LocalMapperConfig& config, const hal::Intrinsics& intrinsics, const hal::DepthNoise& noise = {});
  ~LocalMapper();
  LocalMapper(const LocalMapper&) = delete;
  LocalMapper& operator=(const LocalMapper&) = delete;

  void set_step_hook(StepHook hook);
  FrameReport process(const hal::FrameView& frame);
  void finish();  // no more frames: everything becomes sealed, the last keyframes are fused into the map

  // Sealed keyframes and poses in order; false when there is none (yet). out's memory is reused: reserve_record() it
  // once and no call allocates. Poses come in batches of at most 256. A keyframe that nobody takes until the pool has
  // no other to evict is lost for the outside (counted: keyframes_untaken).
  bool take_keyframe(KeyframeRecord& out);
  bool take_poses(TrajectoryRecord& out);
  static void reserve_record(KeyframeRecord& out, const LocalMapperConfig& config);
  // Blocks of one submap that have settled, at most 256 a record; false when there is none (yet). A block goes out
  // again when it changed again: the later version replaces the earlier one. What the camera has left makes room for
  // new submaps once it was taken. Allocates.
  bool take_submap(SubmapRecord& out);

  // Every submap that is known here: the open ones and those on the shelf. Not for the frame path.
  void for_each_submap(const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const;
  LocalMapperCounters counters() const;
  FocalEstimate focal() const;  // whether the lens is what the camera says
  std::size_t bytes() const;    // memory taken, map included

  // Of the last frame. Valid until the next process().
  MatchPicture last_matches() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::mapping
