#include "mapping/local/local_mapper.hpp"

#include <array>
#include <cassert>
#include <cmath>

#include "tracking/mapper_impl.hpp"

namespace onemap::mapping {

namespace {

double cosine_of_degrees(double degrees) { return std::cos(degrees * 0.017453292519943295); }

FundamentalConfig fundamental_config(const hal::Intrinsics& k, std::uint64_t seed) {
  FundamentalConfig config;
  config.threshold = 2.0 / (0.5 * (k.fx + k.fy));
  config.seed = seed;
  return config;
}

VoxelMapConfig voxel_config(VoxelMapConfig config, const hal::Intrinsics& k) {
  config.image_pixels = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  return config;
}

RigidConfig rigid_config(std::uint64_t seed) {
  RigidConfig config;
  config.seed = seed ^ 0x9E3779B97F4A7C15u;
  return config;
}

}  // namespace

std::string_view to_string(Step step) {
  constexpr std::array<std::string_view, kSteps> names{"gray",   "features", "cloud",  "match",    "fundamental",
                                                       "ransac", "icp",      "refine", "keyframe", "integrate"};
  return step < Step::count ? names[static_cast<std::size_t>(step)] : "count";
}

std::string_view to_string(TrackReason reason) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(TrackReason::count)> names{
      "ok",
      "first frame",
      "too few features",
      "too few matches",
      "fundamental matrix failed",
      "too few coherent depths",
      "3D RANSAC failed",
      "ICP failed",
      "inconsistent motion",
      "time not increasing"};
  return reason < TrackReason::count ? names[static_cast<std::size_t>(reason)] : "count";
}

LocalMapper::Impl::Impl(const LocalMapperConfig& c, const hal::Intrinsics& k)
    : config(c),
      intrinsics(k),
      rays(k),
      focal_px(0.5 * (k.fx + k.fy)),
      keyframe_cos(cosine_of_degrees(c.keyframe_rotation_deg)),
      motion_cos(cosine_of_degrees(c.min_motion_deg)),
      jump_cos(cosine_of_degrees(60)),
      gray(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)),
      matcher({}, static_cast<std::size_t>(c.max_features)),
      fundamental(fundamental_config(k, c.seed), static_cast<std::size_t>(c.max_features)),
      rigid(rigid_config(c.seed), static_cast<std::size_t>(c.max_features)),
      icp(IcpConfig{}),
      voxel_grid(kCloudLeaf_m, gray.size() / (kCloudStride * kCloudStride) + 1024),
      search(k, static_cast<std::size_t>(c.max_features)),
      adjuster(kMaxLocalLandmarks, kMaxWindowObservations),
      map(static_cast<std::size_t>(c.max_keyframes),
          static_cast<std::size_t>(c.max_keyframes) * static_cast<std::size_t>(c.max_features) / 2,
          static_cast<std::size_t>(c.max_features)),
      voxels(voxel_config(c.map, k)),
      trajectory(kTrajectoryRing) {
  const auto n = static_cast<std::size_t>(c.max_features);
  if (c.features == DescriptorKind::surf) {
    SurfConfig s;
    s.max_features = c.max_features;
    surf.emplace(s, k.width, k.height);
  } else {
    orb.emplace(OrbConfig{c.max_features}, k.width, k.height);
  }
  current.reserve(n);
  previous.reserve(n);
  current.set.kind = previous.set.kind = c.features;
  local_landmarks.reserve(kMaxLocalLandmarks);
  raw_points.resize(gray.size() / (kCloudStride * kCloudStride) + 1024);
  source.resize(raw_points.size());
  matches.reserve(n);
  kept.reserve(n);
  coherent.reserve(n);
  pair_of.reserve(n);
  rays_r.reserve(n);
  rays_s.reserve(n);
  points_r.reserve(n);
  points_s.reserve(n);
  observations.reserve(n);
  observation_feature.reserve(n);
  // The first call of each takes its memory.
  const std::vector<std::uint16_t> no_depth(gray.size());
  organize(no_depth, k, kGridWidth, kGridHeight, seen);
  store_grid(seen, map.keyframe(0));
  grid_cloud(map.keyframe(0), restored);
  target = &seen;
}

void LocalMapper::Impl::integrate(const hal::FrameView& frame, const Pose& T_camera_world, FrameReport& report) {
  begin(Step::integrate);
  const Pose moved = T_integrated_world * T_camera_world.inverse();
  if (integrated_once && moved.t.squaredNorm() < config.min_motion_m * config.min_motion_m &&
      rotation_cosine(moved.R) > motion_cos)
    return;
  voxels.integrate(frame, rays, T_camera_world.inverse());
  T_integrated_world = T_camera_world;
  integrated_once = report.integrated = true;
  ++counters.integrated;
  counters.blocks_refused = voxels.counters().blocks_refused;
  counters.frames_short = voxels.counters().frames_short;
}

// The frame is placed: reference, keyframe, trajectory, map.
void LocalMapper::Impl::follow(const hal::FrameView& frame, const Pose& T, FrameReport& report) {
  begin(Step::keyframe);
  report.relocalized = state == TrackState::lost;
  counters.relocalized += report.relocalized;
  state = TrackState::tracking;
  ++counters.tracked;
  ++frames_since_keyframe;
  if (counters.keyframes > 0) choose_reference();
  Pose T_camera_world = T;
  if (counters.keyframes == 0 || wants_keyframe(T, report.inliers)) {
    add_keyframe(frame, T);
    report.keyframe_added = true;
    T_camera_world = map.keyframe(reference).T_camera_world;
  }
  trajectory.add(map, frame.colour_time, reference, map.keyframe(reference).T_camera_world * T_camera_world.inverse());
  integrate(frame, T_camera_world, report);
  T_previous_world = T_camera_world;
  std::swap(current, previous);
  previous_time = frame.colour_time;
  placed = true;
  report.state = state;
  report.reference_keyframe = map.keyframe(reference).index;
  report.T_robot_camera = T_camera_world.inverse();
}

void LocalMapper::Impl::lose(FrameReport& report, TrackReason reason) {
  counters.times_lost += state == TrackState::tracking;
  if (state == TrackState::tracking) state = TrackState::lost;
  ++counters.lost;
  placed = false;
  refuse(report, reason);
}

// The frame is not used. What is known of the camera stays as it is.
void LocalMapper::Impl::refuse(FrameReport& report, TrackReason reason) {
  ++counters.refused[static_cast<std::size_t>(reason)];
  report.reason = reason;
  report.state = state;
}

FrameReport LocalMapper::Impl::process(const hal::FrameView& frame) {
  FrameReport report;
  matched = false;
  ++counters.frames;
  if (last_time && frame.colour_time <= *last_time) {
    refuse(report, TrackReason::time_not_increasing);
    return report;
  }
  last_time = frame.colour_time;
  detect(frame);
  report.features = static_cast<int>(current.size());
  if (report.features < 15) {
    lose(report, TrackReason::too_few_features);
  } else if (counters.keyframes == 0) {
    int with_depth = 0;
    for (std::size_t i = 0; i < current.size(); ++i) with_depth += current.has_depth(i);
    if (with_depth < kKeyframeMinInliers) {
      lose(report, TrackReason::depth_incoherent);
    } else {
      report.reason = TrackReason::first_frame;
      report.inliers = with_depth;
      follow(frame, Pose{}, report);
    }
  } else {
    make_source(frame);
    Pose T_camera_world;
    TrackReason reason = locate(report, T_camera_world);
    const Pose jump = T_previous_world * T_camera_world.inverse();
    if (reason == TrackReason::ok && state == TrackState::tracking &&
        (jump.t.squaredNorm() > 0.25 || rotation_cosine(jump.R) < jump_cos))
      reason = TrackReason::inconsistent_motion;
    if (reason == TrackReason::ok)
      follow(frame, T_camera_world, report);
    else
      lose(report, reason);
  }
  begin(Step::count);
  return report;
}

LocalMapper::LocalMapper(const LocalMapperConfig& config, const hal::Intrinsics& intrinsics)
    : impl_(std::make_unique<Impl>(config, intrinsics)) {
  assert(check(config, intrinsics).ok());
}
LocalMapper::~LocalMapper() = default;

void LocalMapper::set_step_hook(StepHook hook) { impl_->hook = hook; }
FrameReport LocalMapper::process(const hal::FrameView& frame) { return impl_->process(frame); }
VoxelMap& LocalMapper::map() { return impl_->voxels; }
const VoxelMap& LocalMapper::map() const { return impl_->voxels; }
const LocalMapperCounters& LocalMapper::counters() const { return impl_->counters; }

void LocalMapper::finish() {
  while (impl_->window_size > 0) impl_->seal_oldest();
}

bool LocalMapper::take_keyframe(KeyframeRecord& out) {
  const MapKeyframe* keyframe = impl_->map.take_sealed();
  if (keyframe != nullptr) fill_record(*keyframe, out);
  return keyframe != nullptr;
}

bool LocalMapper::take_poses(TrajectoryRecord& out) { return impl_->trajectory.take(out.poses, kPoseBatch); }

void LocalMapper::reserve_record(KeyframeRecord& out, const LocalMapperConfig& config) {
  out.features.reserve(static_cast<std::size_t>(config.max_features));
  out.grid.depth.reserve(static_cast<std::size_t>(kGridWidth) * kGridHeight);
}

std::size_t LocalMapper::bytes() const {
  const Impl& m = *impl_;
  return m.map.bytes() + m.voxels.bytes() + m.adjuster.bytes() + m.trajectory.bytes() + m.voxel_grid.bytes() +
         (m.surf ? m.surf->bytes() : 0) + m.gray.size() * (1 + 2 * sizeof(float)) +
         m.raw_points.size() * 2 * sizeof(Vector3f) +
         static_cast<std::size_t>(kGridWidth) * kGridHeight * 4 * sizeof(Vector3f);
}

LocalMapper::MatchPicture LocalMapper::last_matches() const {
  const Impl& m = *impl_;
  if (!m.matched) return {};
  // The keyframe that was compared may have made room for this frame since.
  if (!m.matched_previous && m.map.keyframe(m.matched_slot).time != m.matched_time) return {};
  // A placed frame was swapped into previous, and what was there into current.
  const FeatureSet& frame = m.placed ? m.previous.set : m.current.set;
  const FeatureSet& last = m.placed ? m.current.set : m.previous.set;
  return {&frame, m.matched_previous ? &last : &m.map.keyframe(m.matched_slot).features.set, m.matched_time, m.matches,
          m.kept};
}

}  // namespace onemap::mapping
