#include "mapper_impl.hpp"

#include <algorithm>

namespace onemap::mapping {

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
  map.seal(slot);
  trajectory.seal(map, slot);
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
  counters.keyframes_evicted = map.evicted();
  counters.keyframes_untaken = map.evicted_untaken();
  if (map.evicted() != evicted) forget_dead_landmarks(current);
  MapKeyframe& k = map.keyframe(slot);
  k.used = true;
  k.sealed = false;
  k.index = static_cast<std::uint32_t>(counters.keyframes++);
  k.time = frame.colour_time;
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

}  // namespace onemap::mapping
