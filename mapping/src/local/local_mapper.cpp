#include "mapping/local/local_mapper.hpp"

#include <algorithm>
#include <cassert>
#include <optional>

#include "surface_builder.hpp"
#include "tracking/focal_watch.hpp"
#include "tracking/front_end.hpp"
#include "tracking/held_frame.hpp"
#include "tracking/keyframe_map.hpp"
#include "tracking/keyframe_record.hpp"
#include "tracking/sealed_trajectory.hpp"
#include "tracking/tracker.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kTrajectoryRing = 16384, kPoseBatch = 256;
constexpr std::chrono::milliseconds kMostOpen{1500};  // a keyframe's pose is final after that

FrontEndConfig front_end_config(const LocalMapperConfig& c) {
  FrontEndConfig out;
  out.features = c.features;
  out.max_features = c.max_features;
  return out;
}

KeyframeMapConfig keyframe_map_config(const LocalMapperConfig& c) {
  return {c.max_keyframes, c.max_features, c.keyframe_translation_m, c.keyframe_rotation_deg};
}

SurfaceBuilderConfig surface_config(const LocalMapperConfig& c, const hal::Intrinsics& k) {
  SurfaceBuilderConfig out{c.map, c.min_motion_m, c.min_motion_deg, c.shelf_bytes};
  out.map.image_pixels = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  return out;
}

}  // namespace

struct LocalMapper::Impl {
  Impl(const LocalMapperConfig& c, const hal::Intrinsics& k, const hal::DepthNoise& noise)
      : front_end(front_end_config(c), k),
        keyframes(keyframe_map_config(c), k, noise),
        tracker({c.max_features, c.seed, noise}, k, front_end.make_observed()),
        surface(surface_config(c, k)),
        trajectory(kTrajectoryRing),
        focal(k, noise, static_cast<std::size_t>(c.max_features), c.seed),
        seen(front_end.make_observed()),
        seen_before(front_end.make_observed()),
        held(k) {}

  FrameReport process(const hal::FrameView& frame);
  void begin_with_held(const hal::FrameView& next);
  FrameReport place(const hal::FrameView& frame);
  bool is_later(FrameTime time);
  void refuse(TrackReason reason, FrameReport& report);
  void lose(TrackReason reason, FrameReport& report);
  Pose settle(const hal::FrameView& frame, const Placed& placed, FrameReport& report);
  void seal_older(FrameTime now);
  void finish();

  FrontEnd front_end;
  KeyframeMap keyframes;
  Tracker tracker;
  SurfaceBuilder surface;
  SealedTrajectory trajectory;
  FocalWatch focal;
  StepHook begin;
  LocalMapperCounters counters;
  Observed seen;                       // the frame that is being processed
  Observed seen_before;                // the first one, while how the camera moves is not known
  HeldFrame held;                      // that frame
  std::optional<FrameTime> last_time;  // of the last frame whose time was in order
};

// The paper's section 3.
FrameReport LocalMapper::Impl::process(const hal::FrameView& frame) {
  FrameReport report;
  ++counters.frames;
  if (!is_later(frame.colour_time)) {
    tracker.skip();
    refuse(TrackReason::time_not_increasing, report);
    return report;
  }
  if (keyframes.empty() && !held.any() && Motion::matters(frame.depth_time, frame.colour_time)) {
    held.hold(frame);
    return report;
  }
  if (held.any()) begin_with_held(frame);
  return place(frame);
}

// Where the first frame's depth belongs is known once it is known how the camera moves.
void LocalMapper::Impl::begin_with_held(const hal::FrameView& next) {
  front_end.observe(held.view(), begin, seen_before);
  front_end.observe(next, begin, seen);
  tracker.see_motion(seen_before, seen, begin);
  held.let_go();
  place(held.view());
}

FrameReport LocalMapper::Impl::place(const hal::FrameView& frame) {
  FrameReport report;
  // SURF features with their points, eq. (5), and the voxel grid's cloud, figure 7.
  seal_older(frame.colour_time);
  front_end.observe(frame, begin, seen, tracker.between_images(frame));
  report.features = static_cast<int>(seen.features.size());

  if (keyframes.empty()) keyframes.look(frame.depth, seen.T_colour_depth);
  // Cross check, fundamental matrix, eq. (6), coherent depths, 3D RANSAC and ICP, figures 4 to 6, and with them eq.
  // (7).
  const Placed placed = tracker.locate(seen, keyframes, begin);
  report.matches = placed.matches;
  report.inliers = placed.inliers;
  if (placed.ok()) {
    // What the next frames are placed by, so that the chain of eq. (7) does not drift; position and rotation, eq. (8).
    begin(Step::keyframe);
    const auto T_colour_depth = tracker.between_images(seen, placed.T_camera_robot);
    const Pose T_camera_robot = settle(frame, placed, report);

    // Points in the local reference, known ones refined; a frame that hardly moved is left out, figure 8.
    begin(Step::integrate);
    const Pose T_depth_robot = T_colour_depth ? T_colour_depth->inverse() * T_camera_robot : T_camera_robot;
    report.integrated = surface.integrate(frame, front_end.rays(), T_depth_robot, keyframes.reference().anchor);
    counters.integrated += report.integrated;
    tracker.follow(seen, frame.colour_time, T_camera_robot);
    report.state = tracker.state();
  } else {
    lose(placed.reason, report);
  }
  begin(Step::count);
  return report;
}

bool LocalMapper::Impl::is_later(FrameTime time) {
  if (last_time && time <= *last_time) return false;
  last_time = time;
  return true;
}

// The frame is not used. What is known of the camera stays as it is.
void LocalMapper::Impl::refuse(TrackReason reason, FrameReport& report) {
  ++counters.refused[static_cast<std::size_t>(reason)];
  report.reason = reason;
  report.state = tracker.state();
}

void LocalMapper::Impl::lose(TrackReason reason, FrameReport& report) {
  counters.times_lost += tracker.state() == TrackState::tracking;
  ++counters.lost;
  tracker.lose();
  refuse(reason, report);
}

// The frame is placed: its reference, perhaps a keyframe, and its place in the trajectory. The pose that it has then.
Pose LocalMapper::Impl::settle(const hal::FrameView& frame, const Placed& placed, FrameReport& report) {
  Pose T_camera_robot = placed.T_camera_robot;
  report.reason = placed.reason;
  report.relocalized = tracker.state() == TrackState::lost;
  counters.relocalized += report.relocalized;
  ++counters.tracked;
  report.keyframe_added = keyframes.follow(seen.features, T_camera_robot, placed.inliers, placed.depth.has_value());
  if (report.keyframe_added) {
    const auto sealed = keyframes.add(frame, T_camera_robot, seen.features, placed.depth, seen.T_colour_depth);
    if (sealed) trajectory.seal(keyframes.landmarks(), *sealed);
    for (const SubmapAnchor& anchor : keyframes.moved_anchors()) surface.place(anchor);
    keyframes.hang_reference(surface.choose(keyframes.reference().T_camera_robot, keyframes.near_anchors()));
    T_camera_robot = keyframes.reference().T_camera_robot;
    focal.look(keyframes);
  }
  trajectory.add(keyframes.landmarks(), frame.colour_time, keyframes.reference_slot(),
                 keyframes.reference().T_camera_robot * T_camera_robot.inverse());
  report.reference_keyframe = keyframes.reference().index;
  report.T_robot_camera = T_camera_robot.inverse();
  return T_camera_robot;
}

// Others get a keyframe soon, also from a camera that stands still or sees nothing.
void LocalMapper::Impl::seal_older(FrameTime now) {
  while (const auto sealed = keyframes.seal_older(now - kMostOpen)) trajectory.seal(keyframes.landmarks(), *sealed);
}

void LocalMapper::Impl::finish() {
  if (held.any()) {
    held.let_go();
    place(held.view());
  }
  while (const auto sealed = keyframes.seal_oldest()) trajectory.seal(keyframes.landmarks(), *sealed);
  surface.finish();
}

LocalMapper::LocalMapper(const LocalMapperConfig& config, const hal::Intrinsics& intrinsics,
                         const hal::DepthNoise& noise)
    : impl_(std::make_unique<Impl>(config, intrinsics, noise)) {
  assert(check(config, intrinsics).ok());
}
LocalMapper::~LocalMapper() = default;

void LocalMapper::set_step_hook(StepHook hook) { impl_->begin = hook; }
FrameReport LocalMapper::process(const hal::FrameView& frame) { return impl_->process(frame); }
void LocalMapper::finish() { impl_->finish(); }
void LocalMapper::for_each_submap(const std::function<void(const SubmapAnchor&, const VoxelMap&)>& fn) const {
  impl_->surface.for_each(fn);
}
FocalEstimate LocalMapper::focal() const { return impl_->focal.estimate(); }
bool LocalMapper::take_submap(SubmapRecord& out) { return impl_->surface.take_submap(out); }
bool LocalMapper::take_poses(TrajectoryRecord& out) { return impl_->trajectory.take(out.poses, kPoseBatch); }
MatchPicture LocalMapper::last_matches() const { return impl_->tracker.last_matches(impl_->seen, impl_->keyframes); }

bool LocalMapper::take_keyframe(KeyframeRecord& out) {
  const MapKeyframe* keyframe = impl_->keyframes.take_sealed();
  if (keyframe != nullptr) fill_record(*keyframe, out);
  return keyframe != nullptr;
}

void LocalMapper::reserve_record(KeyframeRecord& out, const LocalMapperConfig& config) {
  out.features.reserve(static_cast<std::size_t>(config.max_features));
  out.grid.inverse_depth.reserve(static_cast<std::size_t>(kGridWidth) * kGridHeight);
}

LocalMapperCounters LocalMapper::counters() const {
  LocalMapperCounters out = impl_->counters;
  const LandmarkMap& keyframes = impl_->keyframes.landmarks();
  out.keyframes = impl_->keyframes.made();
  out.keyframes_evicted = keyframes.evicted();
  out.keyframes_untaken = keyframes.evicted_untaken();
  out.surface = impl_->surface.counters();
  out.blocks = impl_->surface.blocks();
  return out;
}

std::size_t LocalMapper::bytes() const {
  const Impl& m = *impl_;
  return m.front_end.bytes() + m.keyframes.bytes() + m.tracker.bytes() + m.surface.bytes() + m.trajectory.bytes() +
         m.held.bytes();
}

}  // namespace onemap::mapping
