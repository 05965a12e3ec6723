#include "landmark_map.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <utility>

namespace onemap::mapping {

LandmarkMap::LandmarkMap(std::size_t max_keyframes, std::size_t max_landmarks, std::size_t max_features)
    : keyframes_(max_keyframes) {
  for (MapKeyframe& k : keyframes_) {
    k.features.reserve(max_features);
    k.grid_depth.reserve(static_cast<std::size_t>(kGridWidth) * kGridHeight);
  }
  landmarks_.reserve(max_landmarks);
  free_.reserve(max_landmarks);
  waiting_.reserve(max_keyframes);
}

void LandmarkMap::seal(std::size_t slot) {
  keyframes_[slot].sealed = true;
  waiting_.push_back(slot);
}

const MapKeyframe* LandmarkMap::take_sealed() {
  if (waiting_.empty()) return nullptr;
  const std::size_t slot = waiting_.front();
  waiting_.erase(waiting_.begin());
  return &keyframes_[slot];
}

bool LandmarkMap::waits(std::size_t slot) const {
  return std::find(waiting_.begin(), waiting_.end(), slot) != waiting_.end();
}

std::int32_t LandmarkMap::add_landmark() {
  std::int32_t id = -1;
  if (!free_.empty()) {
    id = free_.back();
    free_.pop_back();
    landmark(id) = Landmark{};
  } else {
    if (landmarks_.size() == landmarks_.capacity()) return -1;
    id = static_cast<std::int32_t>(landmarks_.size());
    landmarks_.emplace_back();
  }
  landmark(id).used = true;
  return id;
}

void LandmarkMap::unlink(MapKeyframe& keyframe, std::size_t feature) {
  const std::int32_t id = std::exchange(keyframe.features.landmark[feature], -1);
  if (id < 0) return;
  Landmark& l = landmark(id);
  if (--l.observations > 0) return;
  l.used = false;
  free_.push_back(id);
}

void LandmarkMap::evict(std::size_t slot) {
  MapKeyframe& k = keyframes_[slot];
  for (std::size_t i = 0; i < k.features.size(); ++i) unlink(k, i);
  k.used = false;
  ++evicted_;
  evicted_untaken_ += std::erase(waiting_, slot);
}

std::size_t LandmarkMap::least_useful(std::span<const std::size_t> keep) const {
  std::size_t worst = keyframes_.size();
  std::pair worst_cost(true, std::numeric_limits<int>::max());
  for (std::size_t slot = 0; slot < keyframes_.size(); ++slot) {
    const MapKeyframe& k = keyframes_[slot];
    if (!k.used || !k.sealed || std::find(keep.begin(), keep.end(), slot) != keep.end()) continue;
    int own = 0;  // landmarks that would be lost or nearly lost with it
    for (const std::int32_t id : k.features.landmark) own += id >= 0 && landmark(id).observations <= 2;
    const std::pair cost(!waiting_.empty() && waits(slot), own);
    if (cost < worst_cost) worst_cost = cost, worst = slot;
  }
  return worst;
}

std::size_t LandmarkMap::take_keyframe_slot(std::span<const std::size_t> keep) {
  for (std::size_t slot = 0; slot < keyframes_.size(); ++slot)
    if (!keyframes_[slot].used) return slot;
  const std::size_t slot = least_useful(keep);
  assert(slot < keyframes_.size() && "the pool is larger than the window");
  evict(slot);
  return slot;
}

void LandmarkMap::make_room(std::size_t landmarks, std::span<const std::size_t> keep) {
  while (free_.size() + landmarks_.capacity() - landmarks_.size() < landmarks) {
    const std::size_t slot = least_useful(keep);
    if (slot == keyframes_.size()) return;
    evict(slot);
  }
}

std::size_t LandmarkMap::covisible(std::uint32_t mark, int min_shared, std::span<std::size_t> out) const {
  constexpr std::size_t kMost = 32;
  std::array<std::pair<int, std::size_t>, kMost> best{};  // (shared, slot), most first
  std::size_t n = 0;
  const std::size_t limit = std::min(out.size(), kMost);
  for (std::size_t slot = 0; slot < keyframes_.size(); ++slot) {
    const MapKeyframe& k = keyframes_[slot];
    if (!k.used) continue;
    int shared = 0;
    for (const std::int32_t id : k.features.landmark) shared += id >= 0 && landmark(id).mark == mark;
    if (shared < min_shared) continue;
    std::size_t at = n;
    while (at > 0 && best[at - 1].first < shared) --at;
    if (at >= limit) continue;
    n = std::min(n + 1, limit);
    for (std::size_t i = n - 1; i > at; --i) best[i] = best[i - 1];
    best[at] = {shared, slot};
  }
  for (std::size_t i = 0; i < n; ++i) out[i] = best[i].second;
  return n;
}

std::size_t LandmarkMap::bytes() const {
  std::size_t total = landmarks_.capacity() * sizeof(Landmark) + free_.capacity() * sizeof(std::int32_t);
  for (const MapKeyframe& k : keyframes_) {
    const std::size_t features = k.features.ray.capacity();
    total += sizeof(MapKeyframe) + k.grid_depth.capacity() * 2;
    total += features * (sizeof(Keypoint) + sizeof(Descriptor) + sizeof(Eigen::Vector2d) + sizeof(Vector3d) +
                         sizeof(std::int32_t));
  }
  return total;
}

}  // namespace onemap::mapping
