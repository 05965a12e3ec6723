#pragma once
// The inside of LocalMapper: its state and the steps of the frame path, in three sources: local_mapper.cpp (the order
// of the steps), locate.cpp (where is the camera?) and keyframes.cpp (what is kept?).
#include <optional>
#include <vector>

#include "guided_search.hpp"
#include "keyframe_record.hpp"
#include "landmark_map.hpp"
#include "mapping/image.hpp"
#include "mapping/local/icp.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/orb.hpp"
#include "mapping/local/ransac.hpp"
#include "mapping/local/surf.hpp"
#include "mapping/local/voxel_grid.hpp"
#include "pose_refiner.hpp"
#include "sealed_trajectory.hpp"
#include "window_adjuster.hpp"

namespace onemap::mapping {

inline constexpr std::size_t kMaxLocalLandmarks = 6000, kMaxWindowObservations = 16000;
inline constexpr std::size_t kTrajectoryRing = 16384, kPoseBatch = 256;
inline constexpr std::size_t kLocalKeyframes = 10, kRelocalizationTries = 4;
inline constexpr int kCloudStride = 4;
inline constexpr float kCloudLeaf_m = 0.05f, kCloudFar_m = 5.0f;
inline constexpr double kLandmarkFar_m = 6.0;
// What ICP may say beside the features: its information is in 1/m^2, colour and depth are up to 20 ms apart.
inline constexpr double kIcpWeight = 0.01;
inline constexpr double kIcpAgree_m = 0.03,
                        kIcpAgreeCosine = 0.9985;  // ICP may correct the features by 3 cm and 3 degrees
inline constexpr int kMinLandmarkInliers = 15, kKeyframeMinInliers = 20;

// Cosine of a rotation's angle: thresholds are compared as cosines.
inline double rotation_cosine(const Matrix3d& R) { return 0.5 * (R.trace() - 1); }

struct LocalMapper::Impl {
  Impl(const LocalMapperConfig& c, const hal::Intrinsics& k);

  FrameReport process(const hal::FrameView& frame);
  void detect(const hal::FrameView& frame);
  void make_source(const hal::FrameView& frame);
  TrackReason locate(FrameReport& report, Pose& T_camera_world);
  TrackReason relative_pose(const FeatureFrame& other, FrameReport& report, Pose& T_other_current);
  TrackReason place(const FeatureFrame& other, const Pose& T_other_world, FrameReport& report, Pose& T_camera_world);
  TrackReason place_by_keyframe(std::size_t slot, FrameReport& report, Pose& T_camera_world);
  TrackReason refine(FrameReport& report, Pose& T_camera_world);
  std::optional<PosePrior> align_depth(const Pose& T_camera_world);
  void follow(const hal::FrameView& frame, const Pose& T_camera_world, FrameReport& report);
  void lose(FrameReport& report, TrackReason reason);
  void refuse(FrameReport& report, TrackReason reason);
  void choose_reference();
  bool wants_keyframe(const Pose& T_camera_world, int inliers) const;
  void add_keyframe(const hal::FrameView& frame, const Pose& T_camera_world);
  void link_landmarks(MapKeyframe& keyframe);
  void seal_oldest();
  void use_reference(std::size_t slot);
  void gather_local_landmarks();
  void integrate(const hal::FrameView& frame, const Pose& T_camera_world, FrameReport& report);
  void forget_dead_landmarks(FeatureFrame& frame);
  void begin(Step step) {
    if (hook.begin) hook.begin(hook.context, step);
  }

  LocalMapperConfig config;
  hal::Intrinsics intrinsics;
  RayTable rays;
  double focal_px;
  double keyframe_cos, motion_cos, jump_cos;
  std::vector<std::uint8_t> gray;
  std::optional<Surf> surf;
  std::optional<Orb> orb;
  Matcher matcher;
  FundamentalRansac fundamental;
  RigidRansac rigid;
  Icp icp;
  VoxelGrid voxel_grid;
  GuidedSearch search;
  WindowAdjuster adjuster;
  LandmarkMap map;
  VoxelMap voxels;
  SealedTrajectory trajectory;
  StepHook hook;
  LocalMapperCounters counters;

  TrackState state = TrackState::starting;
  FeatureFrame current, previous;
  Pose T_previous_world;               // of the last tracked frame
  std::optional<FrameTime> last_time;  // of the last frame whose time was in order
  std::size_t reference = 0;           // slot
  std::size_t relocalization_next = 0;
  std::uint32_t frames_since_keyframe = 0;
  std::array<std::size_t, kWindow> window{};  // slots, oldest first
  std::size_t window_size = 0;
  std::array<std::size_t, kLocalKeyframes> local_keyframes{};
  std::size_t local_keyframe_count = 0;
  std::vector<std::int32_t> local_landmarks;
  bool integrated_once = false;
  Pose T_integrated_world;

  // The reference keyframe's depth: as it was seen, or restored from what the keyframe keeps. Two clouds, because each
  // keeps the sampling pattern of its source.
  OrganizedCloud seen, restored;
  const OrganizedCloud* target = nullptr;
  std::vector<Vector3f> raw_points, source;
  std::size_t source_count = 0;
  std::vector<Match> matches;
  std::vector<std::uint8_t> kept, coherent;
  std::vector<std::uint16_t> pair_of;  // of each 3D pair: index into matches
  std::vector<Eigen::Vector2d> rays_r, rays_s;
  std::vector<Vector3d> points_r, points_s;
  std::vector<PoseObservation> observations;
  std::vector<std::uint32_t> observation_feature;
  // Whether this frame was matched, and with what: the last placed frame, or a keyframe.
  bool matched = false, matched_previous = false, placed = false;
  std::size_t matched_slot = 0;
  FrameTime previous_time{}, matched_time{};
};

}  // namespace onemap::mapping
