#include "keyframe_map.hpp"

#include <algorithm>
#include <utility>

namespace onemap::mapping {

namespace {

constexpr int kNearShared = 8;               // landmarks that a keyframe around the reference shares with it
constexpr double kLandmarkFar_m = 6.0;       // depths beyond make no landmark
constexpr int kKeyframeMinInliers = 20;      // a frame that was placed by fewer makes no keyframe
constexpr std::uint32_t kFramesToRenew = 5;  // after which a frame that knows few of its features makes one
constexpr int kKnownShare = 4;               // few: one of so many

void forget_dead(const LandmarkMap& map, FeatureFrame& features) {
  for (std::int32_t& id : features.landmark)
    if (id >= 0 && !map.landmark(id).used) id = -1;
}

// Seen often enough to be judged, and hardly ever found where it should be.
bool is_stale(const Landmark& l) { return l.visible > 20 && l.found * 8 < l.visible; }

}  // namespace

KeyframeMap::KeyframeMap(const KeyframeMapConfig& config, const hal::Intrinsics& k, const hal::DepthNoise& noise)
    : gate_(config.keyframe_translation_m, config.keyframe_rotation_deg),
      focal_px_(0.5 * (k.fx + k.fy)),
      map_(static_cast<std::size_t>(config.max_keyframes),
           static_cast<std::size_t>(config.max_keyframes) * static_cast<std::size_t>(config.max_features) / 2,
           static_cast<std::size_t>(config.max_features)),
      adjuster_(kMaxNearLandmarks, kMaxWindowObservations),
      cloud_(k, noise) {
  near_landmarks_.reserve(kMaxNearLandmarks);
}

bool KeyframeMap::follow(const FeatureFrame& features, const Pose& T_camera_robot, int inliers, bool led) {
  ++frames_since_keyframe_;
  if (empty()) return true;
  choose_reference(features);
  return wants(features, T_camera_robot, inliers, led);
}

void KeyframeMap::choose_reference(const FeatureFrame& features) {
  const std::uint32_t mark = map_.next_mark();
  for (const std::int32_t id : features.landmark)
    if (id >= 0) map_.landmark(id).mark = mark;
  int best = 0, own = 0;
  std::size_t best_slot = reference_;
  for (std::size_t i = 0; i < near_keyframe_count_; ++i) {
    int shared = 0;
    for (const std::int32_t id : map_.keyframe(near_keyframes_[i]).features.landmark)
      shared += id >= 0 && map_.landmark(id).mark == mark;
    if (near_keyframes_[i] == reference_) own = shared;
    if (shared > best) best = shared, best_slot = near_keyframes_[i];
  }
  if (best_slot != reference_ && 10 * best > 11 * own) use_reference(best_slot);
}

void KeyframeMap::use_reference(std::size_t slot) {
  if (slot != reference_) {
    reference_ = slot;
    cloud_.restore(map_.keyframe(slot));
  }
  gather_near();
}

void KeyframeMap::gather_near() {
  const std::uint32_t seed = map_.next_mark();
  for (const std::int32_t id : reference().features.landmark)
    if (id >= 0) map_.landmark(id).mark = seed;
  near_keyframe_count_ = map_.covisible(seed, kNearShared, near_keyframes_);
  const std::uint32_t listed = map_.next_mark();
  near_landmarks_.clear();
  for (std::size_t i = 0; i < near_keyframe_count_; ++i)
    for (const std::int32_t id : map_.keyframe(near_keyframes_[i]).features.landmark) {
      if (id < 0 || near_landmarks_.size() == kMaxNearLandmarks) continue;
      Landmark& l = map_.landmark(id);
      if (l.mark == listed || is_stale(l)) continue;
      l.mark = listed;
      near_landmarks_.push_back(id);
    }
}

bool KeyframeMap::wants(const FeatureFrame& features, const Pose& T_camera_robot, int inliers, bool led) const {
  if (!led && inliers < kKeyframeMinInliers) return false;
  if (gate_.beyond(reference().T_camera_robot * T_camera_robot.inverse())) return true;
  return inliers >= kKeyframeMinInliers && frames_since_keyframe_ >= kFramesToRenew &&
         kKnownShare * inliers < static_cast<int>(features.size());
}

// A slot of the pool, empty; what had to go for it, the features do not know any more.
MapKeyframe& KeyframeMap::take_keyframe(FeatureFrame& features, std::size_t& slot) {
  const std::array<std::size_t, 1> keep{reference_};
  const std::uint64_t evicted = map_.evicted();
  slot = map_.take_keyframe_slot(keep);
  map_.make_room(features.size(), keep);
  if (map_.evicted() != evicted) forget_dead(map_, features);
  return map_.keyframe(slot);
}

void KeyframeMap::link_landmarks(MapKeyframe& keyframe) {
  FeatureFrame& f = keyframe.features;
  const Pose T_robot_camera = keyframe.T_camera_robot.inverse();
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (f.landmark[i] < 0) {
      if (!f.has_depth(i) || f.point[i].z() > kLandmarkFar_m) continue;
      f.landmark[i] = map_.add_landmark();
      if (f.landmark[i] < 0) continue;
      map_.landmark(f.landmark[i]).p_robot = T_robot_camera * f.point[i];
    }
    Landmark& l = map_.landmark(f.landmark[i]);
    ++l.observations;
    l.descriptor = f.set.descriptors[i];
    l.laplacian = f.set.keypoints[i].laplacian;
  }
}

std::optional<std::size_t> KeyframeMap::add(const hal::FrameView& frame, const Pose& T_camera_robot,
                                            FeatureFrame& features, const std::optional<PosePrior>& depth,
                                            const std::optional<Pose>& T_colour_depth) {
  std::size_t slot = 0;
  MapKeyframe& k = take_keyframe(features, slot);
  k.used = true;
  k.sealed = false;
  k.index = static_cast<std::uint32_t>(made_++);
  k.time = frame.colour_time;
  k.T_camera_robot = T_camera_robot;
  k.depth = depth;
  k.anchor = {k.index, T_camera_robot};  // until it is hung on another one
  copy_features(features, k.features);
  cloud_.see(frame.depth, T_colour_depth, k);
  link_landmarks(k);
  const auto sealed = window_size_ == kWindow ? seal_oldest() : std::nullopt;
  window_[window_size_++] = slot;
  if (made_ > 1) adjuster_.adjust(map_, window(), focal_px_);
  std::copy(k.features.landmark.begin(), k.features.landmark.end(), features.landmark.begin());
  led_from_ = std::exchange(reference_, slot);
  gather_near();
  frames_since_keyframe_ = 0;
  return sealed;
}

std::span<const SubmapAnchor> KeyframeMap::near_anchors() {
  std::size_t count = 0;
  const auto list = [&](std::size_t slot) {
    const SubmapAnchor& anchor = map_.keyframe(slot).anchor;
    const auto known = std::span(anchors_).first(count);
    if (slot != reference_ &&
        std::ranges::none_of(known, [&](const SubmapAnchor& a) { return a.keyframe == anchor.keyframe; }))
      anchors_[count++] = anchor;
  };
  for (std::size_t i = 0; i < near_keyframe_count_; ++i) list(near_keyframes_[i]);
  if (reference().depth && map_.keyframe(led_from_).used) list(led_from_);
  return std::span(anchors_).first(count);
}

void KeyframeMap::hang_reference(const std::optional<SubmapAnchor>& anchor) {
  MapKeyframe& keyframe = map_.keyframe(reference_);
  keyframe.anchor = anchor.value_or(SubmapAnchor{keyframe.index, keyframe.T_camera_robot});
}

std::span<const SubmapAnchor> KeyframeMap::moved_anchors() {
  std::size_t count = 0;
  for (const std::size_t slot : window())
    if (const MapKeyframe& k = map_.keyframe(slot); k.anchor.keyframe == k.index)
      anchors_[count++] = {k.index, k.T_camera_robot};
  const auto moved = std::span(anchors_).first(count);
  for (std::size_t slot = 0; count > 0 && slot < map_.keyframe_capacity(); ++slot)
    for (const SubmapAnchor& anchor : moved)
      if (MapKeyframe& k = map_.keyframe(slot); k.used && k.anchor.keyframe == anchor.keyframe) k.anchor = anchor;
  return moved;
}

std::optional<std::size_t> KeyframeMap::seal_oldest() {
  if (window_size_ == 0) return std::nullopt;
  const std::size_t slot = window_[0];
  std::copy(window_.begin() + 1, window_.begin() + static_cast<std::ptrdiff_t>(window_size_), window_.begin());
  --window_size_;
  map_.seal(slot);
  return slot;
}

std::optional<std::size_t> KeyframeMap::seal_older(FrameTime then) {
  const bool old = window_size_ > 0 && map_.keyframe(window_[0]).time < then;
  return old ? seal_oldest() : std::nullopt;
}

}  // namespace onemap::mapping
