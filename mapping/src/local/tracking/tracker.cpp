#include "tracker.hpp"

#include <algorithm>
#include <utility>

namespace onemap::mapping {

namespace {

constexpr std::size_t kMinFeatures = 15;
constexpr int kMinFirstDepths = 20;  // features with depth of the first frame
constexpr int kMinLandmarkInliers = 15;
constexpr std::size_t kRelocalisationTries = 4;            // keyframes a frame
constexpr double kJump_m = 0.5, kJump_deg = 60;            // between two frames; more is a mistake
constexpr std::size_t kRichFeatures = 150;                 // with more features, colour has something to say
constexpr std::chrono::milliseconds kLongestUnseen{1500};  // for which a direction may be the motion's alone
// What ICP may say beside the features: its information is in 1/m^2, colour and depth are up to 20 ms apart.
constexpr double kIcpWeight = 0.01;
// ICP may correct the features by 3 cm and 3 degrees.
constexpr double kIcpAgree_m = 0.03, kIcpAgreeCosine = 0.9985;

TwoViewConfig two_view_config(const TrackerConfig& config, const hal::Intrinsics& k) {
  TwoViewConfig out;
  out.fundamental.threshold = 2.0 / (0.5 * (k.fx + k.fy));
  out.fundamental.seed = config.seed;
  out.rigid.noise = config.noise;
  out.rigid.seed = config.seed ^ 0x9E3779B97F4A7C15u;
  return out;
}

TrackReason track_reason(TwoViewReason reason) {
  switch (reason) {
    case TwoViewReason::ok:
      return TrackReason::ok;
    case TwoViewReason::too_few_matches:
      return TrackReason::too_few_matches;
    case TwoViewReason::fundamental_failed:
      return TrackReason::fundamental_failed;
    case TwoViewReason::depth_incoherent:
      return TrackReason::depth_incoherent;
    case TwoViewReason::ransac_failed:
      break;
  }
  return TrackReason::ransac_failed;
}

}  // namespace

Tracker::Tracker(const TrackerConfig& config, const hal::Intrinsics& k, Observed spare)
    : two_view_(two_view_config(config, k), static_cast<std::size_t>(config.max_features)),
      icp_(IcpConfig{}),
      fit_(k, static_cast<std::size_t>(config.max_features)),
      jump_gate_(kJump_m, kJump_deg),
      previous_(std::move(spare)) {}

Placed Tracker::locate(Observed& seen, KeyframeMap& map, const StepHook& begin) {
  compared_ = {};
  placed_ = false;
  if (map.empty()) return first(seen, map);
  Placed placed{TrackReason::too_few_features, {}, 0, 0, {}};
  if (seen.features.size() >= kMinFeatures) placed = by_known_images(seen, map, begin);
  lead_where_colour_is_poor(seen, map, begin, placed);
  const Pose jump = T_previous_robot_ * placed.T_camera_robot.inverse();
  if (placed.ok() && state_ == TrackState::tracking && jump_gate_.beyond(jump))
    placed.reason = TrackReason::inconsistent_motion;
  return placed;
}

// The robot's own frame is where its first camera is; features or depth must be able to tell where the next one is.
Placed Tracker::first(const Observed& seen, const KeyframeMap& map) const {
  const FeatureFrame& features = seen.features;
  int with_depth = 0;
  for (std::size_t i = 0; i < features.size(); ++i) with_depth += features.has_depth(i);
  const bool by_depth =
      features.size() < kRichFeatures && seen.lens_open && depth_sees_all(map.reference_cloud(), seen.cloud, icp_);
  if (!by_depth && features.size() < kMinFeatures) return {TrackReason::too_few_features, {}, 0, 0, {}};
  if (!by_depth && with_depth < kMinFirstDepths) return {TrackReason::depth_incoherent, {}, 0, 0, {}};
  return {TrackReason::first_frame, {}, 0, with_depth, {}};
}

void Tracker::see_motion(const Observed& first, const Observed& second, const StepHook& begin) {
  const double passed_s = to_seconds(second.time - first.time);
  const TwoViewResult& motion = two_view_.relate(second.features, first.features, begin);
  if (motion.reason == TwoViewReason::ok && passed_s > 0)
    motion_.start(motion_between(Pose(), motion.T_b_a.inverse()) / passed_s);
}

std::optional<Pose> Tracker::between_images(const Observed& seen, const Pose& T_camera_robot) const {
  constexpr double kLongestStep_s = 0.3;
  const double apart_s = to_seconds(seen.time - seen.depth_time), passed_s = to_seconds(seen.time - previous_time_);
  if (!Motion::matters(seen.depth_time, seen.time)) return std::nullopt;
  if (state_ != TrackState::tracking || !(passed_s > 0 && passed_s <= kLongestStep_s)) return seen.T_colour_depth;
  const double share = std::clamp(apart_s / passed_s, -1.0, 1.0);
  return small_motion(share * motion_between(T_previous_robot_, T_camera_robot));
}

Placed Tracker::by_known_images(Observed& seen, KeyframeMap& map, const StepHook& begin) {
  Placed placed;
  placed.reason = by_previous(seen, map, begin, placed);
  if (placed.ok()) return placed;
  const std::size_t reference = map.reference_slot();
  TrackReason reason = by_keyframe(reference, seen, map, begin, placed);
  if (reason != TrackReason::ok && state_ == TrackState::lost) reason = relocalise(seen, map, begin, placed);
  if (reason == TrackReason::ok) placed.reason = reason;  // else the first that failed says why
  return placed;
}

// Some more keyframes a frame, each the reference while it is tried, until one fits.
TrackReason Tracker::relocalise(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed) {
  const std::size_t reference = map.reference_slot(), slots = map.landmarks().keyframe_capacity();
  for (std::size_t tries = 0, looked = 0; tries < kRelocalisationTries && looked < slots; ++looked) {
    const std::size_t slot = std::exchange(relocalisation_next_, (relocalisation_next_ + 1) % slots);
    if (!map.landmarks().keyframe(slot).used || slot == reference) continue;
    ++tries;
    map.use_reference(slot);
    if (by_keyframe(slot, seen, map, begin, placed) == TrackReason::ok) return TrackReason::ok;
  }
  map.use_reference(reference);
  return TrackReason::ransac_failed;
}

TrackReason Tracker::by_previous(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed) {
  compared_ = {Compared::With::previous, 0, previous_time_};
  return by_image(previous_.features, T_previous_robot_, seen, map, begin, placed);
}

TrackReason Tracker::by_keyframe(std::size_t slot, Observed& seen, KeyframeMap& map, const StepHook& begin,
                                 Placed& placed) {
  const MapKeyframe& k = map.landmarks().keyframe(slot);
  compared_ = {Compared::With::keyframe, slot, k.time};
  return by_image(k.features, k.T_camera_robot, seen, map, begin, placed);
}

// Places the frame by another image whose pose is known: the motion between the two, ICP, and the landmarks near by.
TrackReason Tracker::by_image(const FeatureFrame& other, const Pose& T_other_robot, Observed& seen, KeyframeMap& map,
                              const StepHook& begin, Placed& placed) {
  FeatureFrame& features = seen.features;
  const TwoViewResult& motion = two_view_.relate(features, other, begin);
  placed.matches = static_cast<int>(motion.matches.size());
  if (motion.reason != TwoViewReason::ok) return track_reason(motion.reason);
  placed.T_camera_robot = motion.T_b_a.inverse() * T_other_robot;  // eq. (7)
  std::fill(features.landmark.begin(), features.landmark.end(), -1);
  for (std::size_t i = 0; i < motion.matches.size(); ++i)
    if (motion.kept[i]) features.landmark[motion.matches[i].a] = other.landmark[motion.matches[i].b];
  begin(Step::icp);
  const auto prior = align_depth(seen, map, placed.T_camera_robot);
  begin(Step::refine);
  placed.inliers = fit_.fit(features, map.landmarks(), map.near(), prior ? &*prior : nullptr, placed.T_camera_robot);
  return placed.inliers >= kMinLandmarkInliers ? TrackReason::ok : TrackReason::ransac_failed;
}

// Few landmarks, or none: where the camera should be is looked for in depth, and what landmarks there are join. A
// direction that nothing tells is taken from the motion, for a while.
void Tracker::lead_where_colour_is_poor(Observed& seen, KeyframeMap& map, const StepHook& begin, Placed& placed) {
  const bool by_colour = placed.ok();
  auto expected = motion_.at(seen.time);
  if (!expected && by_colour)
    expected = Motion::Expected{placed.T_camera_robot, Eigen::Matrix<double, 6, 6>::Identity()};  // after a pause
  const bool poor = by_colour ? !sees_all(fit_.information(placed.T_camera_robot), mean_depth(seen.cloud))
                              : seen.features.size() < kRichFeatures;
  const auto led = poor && expected && seen.lens_open
                       ? lead_by_depth(seen, map, *expected, by_colour, icp_, fit_, begin)
                       : std::nullopt;
  if (!led) {
    if (by_colour) all_seen_ = seen.time;
    return;
  }
  if (led->all_seen) all_seen_ = seen.time;
  placed.reason = seen.time - all_seen_ <= kLongestUnseen ? TrackReason::ok : TrackReason::direction_unseen;
  placed.T_camera_robot = led->T_camera_robot;
  placed.inliers = led->inliers;
  placed.depth = led->depth;
}

// ICP (figure 6) of the frame's cloud against the reference keyframe's; its answer is a prior for the landmark fit if
// it agrees with the guess.
std::optional<PosePrior> Tracker::align_depth(const Observed& seen, const KeyframeMap& map,
                                              const Pose& T_camera_robot) const {
  const Pose T_reference_robot = map.reference().T_camera_robot;
  const Pose guess = T_reference_robot * T_camera_robot.inverse();
  const IcpResult r = icp_.align(map.reference_cloud(), seen.cloud, guess);
  if (!r.converged) return std::nullopt;
  const Pose off = guess.inverse() * r.T_target_source;
  if (off.t.squaredNorm() > kIcpAgree_m * kIcpAgree_m || rotation_cosine(off.R) < kIcpAgreeCosine) return std::nullopt;
  PosePrior prior;
  prior.T_camera_robot = r.T_target_source.inverse() * T_reference_robot;
  prior.information = kIcpWeight * information_of_inverse(r.information, r.T_target_source);
  return prior;
}

void Tracker::follow(Observed& seen, FrameTime time, const Pose& T_camera_robot) {
  state_ = TrackState::tracking;
  motion_.follow(time, T_camera_robot);
  T_previous_robot_ = T_camera_robot;
  previous_time_ = time;
  std::swap(seen, previous_);
  placed_ = true;
}

void Tracker::lose() {
  if (state_ == TrackState::tracking) state_ = TrackState::lost;
}

MatchPicture Tracker::last_matches(const Observed& seen, const KeyframeMap& map) const {
  if (compared_.with == Compared::With::nothing) return {};
  // A placed frame was swapped into previous_, and what was there into seen.
  const FeatureSet* frame = placed_ ? &previous_.features.set : &seen.features.set;
  const FeatureSet* other = placed_ ? &seen.features.set : &previous_.features.set;
  if (compared_.with == Compared::With::keyframe) {
    const MapKeyframe& k = map.landmarks().keyframe(compared_.slot);
    if (k.time != compared_.time) return {};  // it made room for this frame since
    other = &k.features.set;
  }
  return {frame, other, compared_.time, two_view_.last().matches, two_view_.last().kept};
}

}  // namespace onemap::mapping
