#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "hal/frame.hpp"
#include "mapping/local/features.hpp"
#include "mapping/local/mapper_config.hpp"
#include "mapping/local/voxel_map.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::mapping {

// The steps of a frame, in order; for timing by whoever owns a clock.
enum class Step : std::uint8_t {
  gray,
  features,
  cloud,
  match,
  fundamental,
  ransac,
  icp,
  refine,
  keyframe,
  integrate,
  count
};
inline constexpr std::size_t kSteps = static_cast<std::size_t>(Step::count);
std::string_view to_string(Step step);

// Called when a step begins, and with Step::count when the frame is done.
struct StepHook {
  void (*begin)(void* context, Step step) = nullptr;
  void* context = nullptr;
};

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
  count
};
std::string_view to_string(TrackReason reason);

struct FrameReport {
  TrackState state = TrackState::starting;
  TrackReason reason = TrackReason::ok;
  bool keyframe_added = false;
  bool integrated = false;   // added to the voxel map
  bool relocalized = false;  // placed again after being lost
  int features = 0, matches = 0, inliers = 0;
  std::uint32_t reference_keyframe = 0;
  Pose T_robot_camera;  // current estimate; meaningful when state == tracking
};

struct LocalMapperCounters {
  std::uint64_t frames = 0, tracked = 0, lost = 0, times_lost = 0, relocalized = 0, integrated = 0;
  std::uint64_t keyframes = 0;          // ever made; those of the optimisation window are not handed out yet
  std::uint64_t keyframes_evicted = 0;  // of these, to make room; so keyframes - keyframes_evicted are in the map
  std::uint64_t keyframes_untaken = 0;  // of these, before anybody took them
  std::uint64_t blocks_refused = 0;     // missed for want of room in the voxel map, each once a frame
  std::uint64_t frames_short = 0;       // frames that missed blocks
  std::array<std::uint64_t, static_cast<std::size_t>(TrackReason::count)> refused{};  // by reason

  std::uint64_t keyframes_in_map() const { return keyframes - keyframes_evicted; }
};

// One robot's tracking and map: the paper's section 3. process() runs the whole frame path on the caller's thread and
// does not allocate after the constructor. What leaves the robot (keyframes, poses) is taken in sealed form: a
// keyframe's pose may still move a little while it is in the optimisation window, so it is handed out when it leaves
// it.
class LocalMapper {
 public:
  // check(config, intrinsics) must have passed.
  LocalMapper(const LocalMapperConfig& config, const hal::Intrinsics& intrinsics);
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

  VoxelMap& map();
  const VoxelMap& map() const;
  const LocalMapperCounters& counters() const;
  std::size_t bytes() const;  // memory taken, map included

  // The matches of the last frame with the image that it was last compared with (the frame before or a keyframe, known
  // by its time): figure 4. frame is nullptr when it was compared with none. Valid until the next process().
  struct MatchPicture {
    const FeatureSet* frame = nullptr;
    const FeatureSet* other = nullptr;
    FrameTime other_time{};
    std::span<const Match> matches;      // a: frame, b: other
    std::span<const std::uint8_t> kept;  // 1 kept, 0 rejected
  };
  MatchPicture last_matches() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::mapping
