#include "mapping/local/local_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mapping/image.hpp"
#include "mapping/local/icp.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/orb.hpp"
#include "mapping/local/ransac.hpp"
#include "mapping/local/surf.hpp"
#include "mapping/local/voxel_grid.hpp"
#include "tracking/guided_search.hpp"
#include "tracking/keyframe_record.hpp"
#include "tracking/landmark_map.hpp"
#include "tracking/pose_refiner.hpp"
#include "tracking/sealed_trajectory.hpp"
#include "tracking/window_adjuster.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kMaxLocalLandmarks = 6000, kMaxWindowObservations = 16000;
constexpr std::size_t kTrajectoryRing = 16384, kPoseBatch = 256;
constexpr std::size_t kLocalKeyframes = 10, kRelocalizationTries = 4;
constexpr int kCloudStride = 4;
constexpr float kCloudLeaf_m = 0.05f, kCloudFar_m = 5.0f;
constexpr double kLandmarkFar_m = 6.0;
// What ICP may say beside the features: its information is in 1/m^2, colour and depth are up to 20 ms apart.
constexpr double kIcpWeight = 0.01;
constexpr double kIcpAgree_m = 0.03, kIcpAgreeCosine = 0.9985;  // ICP may correct the features by 3 cm and 3 degrees
constexpr int kMinLandmarkInliers = 15, kKeyframeMinInliers = 20;

double cosine_of_degrees(double degrees) { return std::cos(degrees * 0.017453292519943295); }

// Cosine of a rotation's angle: thresholds are compared as cosines.
double rotation_cosine(const Matrix3d& R) { return 0.5 * (R.trace() - 1); }

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
  Pose T_previous_world;  // of the last tracked frame
  FrameTime last_time{};
  std::size_t reference = 0;  // slot
  std::size_t relocalization_next = 0;
  std::uint32_t frames_since_keyframe = 0;
  std::array<std::size_t, kWindow> window{};  // slots, oldest first
  std::size_t window_size = 0;
  std::array<std::size_t, kLocalKeyframes> local_keyframes{};
  std::size_t local_keyframe_count = 0;
  std::vector<std::int32_t> local_landmarks;
  std::vector<std::size_t> sealed_slots;  // not taken yet
  std::size_t sealed_taken = 0;
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
  // What the last matches were with: the last placed frame, or a keyframe.
  bool matched_previous = false, placed = false;
  std::size_t matched_slot = 0;
  FrameTime previous_time{}, matched_time{};
};

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
  sealed_slots.reserve(static_cast<std::size_t>(c.max_keyframes));
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

void LocalMapper::Impl::detect(const hal::FrameView& frame) {
  begin(Step::gray);
  to_gray(frame.rgb, gray);
  begin(Step::features);
  const GrayView view{gray.data(), intrinsics.width, intrinsics.height, intrinsics.width};
  if (surf)
    surf->detect(view, current.set);
  else
    orb->detect(view, current.set);
  attach_geometry(current, frame.depth, rays, intrinsics.depth_scale);
}

// Eq. (5) and figure 7: the frame's cloud, voxel-grid downsampled, as ICP's source.
void LocalMapper::Impl::make_source(const hal::FrameView& frame) {
  begin(Step::cloud);
  std::size_t n = to_points(frame.depth, rays, intrinsics.depth_scale, kCloudStride, raw_points);
  n = static_cast<std::size_t>(std::remove_if(raw_points.begin(), raw_points.begin() + static_cast<std::ptrdiff_t>(n),
                                              [](const Vector3f& p) { return p.z() > kCloudFar_m; }) -
                               raw_points.begin());
  source_count = voxel_grid.downsample({raw_points.data(), n}, source);
}

// Section 3 for two images: mutual nearest neighbours, fundamental matrix (eq. 6), coherent depths, 3D RANSAC.
TrackReason LocalMapper::Impl::relative_pose(const FeatureFrame& other, FrameReport& report, Pose& T_other_current) {
  begin(Step::match);
  const auto found = matcher.match(current.set, other.set);
  matches.assign(found.begin(), found.end());
  kept.assign(matches.size(), 0);
  report.matches = static_cast<int>(matches.size());
  if (matches.size() < 15) return TrackReason::too_few_matches;

  begin(Step::fundamental);
  rays_r.clear();
  rays_s.clear();
  for (const Match& m : matches) {
    rays_r.push_back(other.ray[m.b]);
    rays_s.push_back(current.ray[m.a]);
  }
  Matrix3d F;
  if (!fundamental.estimate(rays_r, rays_s, kept, F).ok()) return TrackReason::fundamental_failed;

  begin(Step::ransac);
  points_r.clear();
  points_s.clear();
  pair_of.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!kept[i]) continue;
    kept[i] = 0;  // kept until the 3D RANSAC says so
    if (!other.has_depth(matches[i].b) || !current.has_depth(matches[i].a)) continue;
    points_r.push_back(other.point(matches[i].b));
    points_s.push_back(current.point(matches[i].a));
    pair_of.push_back(static_cast<std::uint16_t>(i));
  }
  if (points_r.size() < 12) return TrackReason::depth_incoherent;
  coherent.assign(points_r.size(), 0);
  if (!rigid.estimate(points_r, points_s, coherent, T_other_current).ok()) return TrackReason::ransac_failed;
  for (std::size_t i = 0; i < coherent.size(); ++i) kept[pair_of[i]] = coherent[i];
  return TrackReason::ok;
}

// ICP of the frame's cloud against the reference keyframe's; its answer is a prior for the refinement if it agrees with
// the guess.
std::optional<PosePrior> LocalMapper::Impl::align_depth(const Pose& T_camera_world) {
  begin(Step::icp);
  const Pose T_reference_world = map.keyframe(reference).T_camera_world;
  const Pose guess = T_reference_world * T_camera_world.inverse();
  const IcpResult r = icp.align(*target, {source.data(), source_count}, guess);
  if (!r.converged) return std::nullopt;
  const Pose off = guess.inverse() * r.T_target_source;
  if (off.t.squaredNorm() > kIcpAgree_m * kIcpAgree_m || rotation_cosine(off.R) < kIcpAgreeCosine) return std::nullopt;
  PosePrior prior;
  prior.T_camera_world = r.T_target_source.inverse() * T_reference_world;
  prior.information = kIcpWeight * information_of_inverse(r.information, r.T_target_source);
  return prior;
}

TrackReason LocalMapper::Impl::refine(FrameReport& report, Pose& T_camera_world) {
  const auto prior = align_depth(T_camera_world);
  begin(Step::refine);
  search.index(current);
  SearchConfig near;
  if (current.set.kind == DescriptorKind::orb) near.max_distance = 60;
  search.find(map, local_landmarks, T_camera_world, near, current);
  observations.clear();
  observation_feature.clear();
  for (std::size_t i = 0; i < current.size(); ++i) {
    if (current.landmark[i] < 0) continue;
    const double size = std::max(1.0, static_cast<double>(current.set.keypoints[i].size_px) / 24.0);
    observations.push_back({map.landmark(current.landmark[i]).p_world,
                            {current.ray[i], current.has_depth(i) ? 1 / current.depth_m[i] : 0.0, 1 / (size * size)},
                            true});
    observation_feature.push_back(static_cast<std::uint32_t>(i));
  }
  const RefineResult r = refine_pose(observations, focal_px, prior ? &*prior : nullptr, T_camera_world);
  report.inliers = r.inliers;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    std::int32_t& id = current.landmark[observation_feature[i]];
    if (observations[i].inlier)
      ++map.landmark(id).found;
    else
      id = -1;
  }
  return r.inliers >= kMinLandmarkInliers ? TrackReason::ok : TrackReason::ransac_failed;
}

// Tries to place the current frame by one other image whose pose is known.
TrackReason LocalMapper::Impl::place(const FeatureFrame& other, const Pose& T_other_world, FrameReport& report,
                                     Pose& T_camera_world) {
  Pose T_other_current;
  if (const auto reason = relative_pose(other, report, T_other_current); reason != TrackReason::ok) return reason;
  T_camera_world = T_other_current.inverse() * T_other_world;  // eq. (7)
  std::fill(current.landmark.begin(), current.landmark.end(), -1);
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (kept[i]) current.landmark[matches[i].a] = other.landmark[matches[i].b];
  return refine(report, T_camera_world);
}

TrackReason LocalMapper::Impl::place_by_keyframe(std::size_t slot, FrameReport& report, Pose& T_camera_world) {
  const MapKeyframe& k = map.keyframe(slot);
  matched_previous = false;
  matched_slot = slot;
  matched_time = k.time;
  return place(k.features, k.T_camera_world, report, T_camera_world);
}

TrackReason LocalMapper::Impl::locate(FrameReport& report, Pose& T_camera_world) {
  matched_previous = true;
  matched_time = previous_time;
  TrackReason reason = place(previous, T_previous_world, report, T_camera_world);
  if (reason == TrackReason::ok) return reason;
  const std::size_t first_reference = reference;
  if (place_by_keyframe(reference, report, T_camera_world) == TrackReason::ok) return TrackReason::ok;
  if (state != TrackState::lost) return reason;
  for (std::size_t tries = 0, looked = 0; tries < kRelocalizationTries && looked < map.keyframe_capacity(); ++looked) {
    const std::size_t slot = relocalization_next;
    relocalization_next = (relocalization_next + 1) % map.keyframe_capacity();
    if (!map.keyframe(slot).used || slot == first_reference) continue;
    ++tries;
    use_reference(slot);
    if (place_by_keyframe(slot, report, T_camera_world) == TrackReason::ok) return TrackReason::ok;
  }
  use_reference(first_reference);
  return reason;
}

// The keyframe of the neighbourhood that shares most landmarks with the frame becomes the reference.
void LocalMapper::Impl::choose_reference() {
  const std::uint32_t mark = map.next_mark();
  for (const std::int32_t id : current.landmark)
    if (id >= 0) map.landmark(id).mark = mark;
  int best = 0, own = 0;
  std::size_t best_slot = reference;
  for (std::size_t i = 0; i < local_keyframe_count; ++i) {
    int shared = 0;
    for (const std::int32_t id : map.keyframe(local_keyframes[i]).features.landmark)
      shared += id >= 0 && map.landmark(id).mark == mark;
    if (local_keyframes[i] == reference) own = shared;
    if (shared > best) best = shared, best_slot = local_keyframes[i];
  }
  if (best_slot != reference && 10 * best > 11 * own) use_reference(best_slot);
}

void LocalMapper::Impl::use_reference(std::size_t slot) {
  if (slot != reference) {
    reference = slot;
    grid_cloud(map.keyframe(slot), restored);
    target = &restored;
  }
  gather_local_landmarks();
}

// The landmarks that the reference and the keyframes around it see.
void LocalMapper::Impl::gather_local_landmarks() {
  const std::uint32_t seed = map.next_mark();
  for (const std::int32_t id : map.keyframe(reference).features.landmark)
    if (id >= 0) map.landmark(id).mark = seed;
  local_keyframe_count = map.covisible(seed, 8, local_keyframes);
  const std::uint32_t listed = map.next_mark();
  local_landmarks.clear();
  for (std::size_t i = 0; i < local_keyframe_count; ++i)
    for (const std::int32_t id : map.keyframe(local_keyframes[i]).features.landmark) {
      if (id < 0 || local_landmarks.size() == kMaxLocalLandmarks) continue;
      Landmark& l = map.landmark(id);
      if (l.mark == listed || (l.visible > 20 && l.found * 8 < l.visible)) continue;
      l.mark = listed;
      local_landmarks.push_back(id);
    }
}

bool LocalMapper::Impl::wants_keyframe(const Pose& T_camera_world, int inliers) const {
  if (inliers < kKeyframeMinInliers) return false;
  const Pose moved = map.keyframe(reference).T_camera_world * T_camera_world.inverse();
  if (moved.t.squaredNorm() > config.keyframe_translation_m * config.keyframe_translation_m) return true;
  if (rotation_cosine(moved.R) < keyframe_cos) return true;
  return frames_since_keyframe >= 5 && 4 * inliers < static_cast<int>(current.size());
}

void LocalMapper::Impl::link_landmarks(MapKeyframe& keyframe) {
  FeatureFrame& f = keyframe.features;
  const Pose T_world_camera = keyframe.T_camera_world.inverse();
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (f.landmark[i] < 0) {
      if (!f.has_depth(i) || f.depth_m[i] > kLandmarkFar_m) continue;
      f.landmark[i] = map.add_landmark();
      if (f.landmark[i] < 0) continue;
      map.landmark(f.landmark[i]).p_world = T_world_camera * f.point(i);
    }
    Landmark& l = map.landmark(f.landmark[i]);
    ++l.observations;
    l.descriptor = f.set.descriptors[i];
    l.laplacian = f.set.keypoints[i].laplacian;
  }
}

void LocalMapper::Impl::seal_oldest() {
  const std::size_t slot = window[0];
  std::copy(window.begin() + 1, window.begin() + static_cast<std::ptrdiff_t>(window_size), window.begin());
  --window_size;
  map.keyframe(slot).sealed = true;
  trajectory.seal(map, slot);
  if (sealed_slots.size() < sealed_slots.capacity()) sealed_slots.push_back(slot);
}

void LocalMapper::Impl::forget_dead_landmarks(FeatureFrame& frame) {
  for (std::int32_t& id : frame.landmark)
    if (id >= 0 && !map.landmark(id).used) id = -1;
}

void LocalMapper::Impl::add_keyframe(const hal::FrameView& frame, const Pose& T_camera_world) {
  const std::array<std::size_t, 1> keep{reference};
  const std::uint64_t evicted = map.evicted();
  const std::size_t slot = map.take_keyframe_slot(keep);
  map.make_room(current.size(), keep);
  counters.keyframes_evicted += map.evicted() - evicted;
  if (map.evicted() != evicted) forget_dead_landmarks(current);
  MapKeyframe& k = map.keyframe(slot);
  k.used = true;
  k.sealed = false;
  k.index = static_cast<std::uint32_t>(counters.keyframes++);
  k.time = frame.time;
  k.T_camera_world = T_camera_world;
  copy_features(current, k.features);
  organize(frame.depth, intrinsics, kGridWidth, kGridHeight, seen);
  target = &seen;
  store_grid(seen, k);
  link_landmarks(k);
  if (window_size == kWindow) seal_oldest();
  window[window_size++] = slot;
  if (window_size > 1) adjuster.adjust(map, {window.data(), window_size}, focal_px);
  std::copy(k.features.landmark.begin(), k.features.landmark.end(), current.landmark.begin());
  reference = slot;
  gather_local_landmarks();
  frames_since_keyframe = 0;
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
  trajectory.add(map, frame.time, reference, map.keyframe(reference).T_camera_world * T_camera_world.inverse());
  integrate(frame, T_camera_world, report);
  T_previous_world = T_camera_world;
  std::swap(current, previous);
  previous_time = frame.time;
  placed = true;
  report.state = state;
  report.reference_keyframe = map.keyframe(reference).index;
  report.T_robot_camera = T_camera_world.inverse();
}

void LocalMapper::Impl::lose(FrameReport& report, TrackReason reason) {
  counters.times_lost += state == TrackState::tracking;
  if (state == TrackState::tracking) state = TrackState::lost;
  ++counters.lost;
  ++counters.refused[static_cast<std::size_t>(reason)];
  report.reason = reason;
  report.state = state;
  placed = false;
}

FrameReport LocalMapper::Impl::process(const hal::FrameView& frame) {
  FrameReport report;
  const bool ordered = counters.frames == 0 || frame.time > last_time;
  ++counters.frames;
  if (!ordered) {
    lose(report, TrackReason::time_not_increasing);
    return report;
  }
  last_time = frame.time;
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
    : impl_(std::make_unique<Impl>(config, intrinsics)) {}
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
  if (impl_->sealed_taken == impl_->sealed_slots.size()) {
    impl_->sealed_slots.clear();
    impl_->sealed_taken = 0;
    return false;
  }
  fill_record(impl_->map.keyframe(impl_->sealed_slots[impl_->sealed_taken++]), out);
  return true;
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
  if (m.counters.keyframes == 0 || m.matched_time == FrameTime{}) return {};
  // A placed frame was swapped into previous, and what was there into current.
  const FeatureSet& frame = m.placed ? m.previous.set : m.current.set;
  const FeatureSet& last = m.placed ? m.current.set : m.previous.set;
  return {&frame, m.matched_previous ? &last : &m.map.keyframe(m.matched_slot).features.set, m.matched_time, m.matches,
          m.kept};
}

}  // namespace onemap::mapping
