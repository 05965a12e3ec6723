#include "sealed_trajectory.hpp"

namespace onemap::mapping {

SealedTrajectory::SealedTrajectory(std::size_t capacity) : ring_(capacity) {}

void SealedTrajectory::finalize(const LandmarkMap& map, Entry& e) {
  if (e.final) return;
  e.pose = map.keyframe(e.slot).T_camera_robot.inverse() * e.pose;
  e.final = true;
}

void SealedTrajectory::add(const LandmarkMap& map, FrameTime time, std::size_t slot, const Pose& T_reference_camera) {
  if (count_ == ring_.size()) {  // nobody takes: the oldest gives way
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
  Entry& e = at(count_++);
  e = {time, slot, false, T_reference_camera};
  if (map.keyframe(slot).sealed) finalize(map, e);
  // A camera that stands still makes no keyframes: its frames become final by age.
  if (count_ > ring_.size() / 2) finalize(map, at(0));
}

void SealedTrajectory::seal(const LandmarkMap& map, std::size_t slot) {
  for (std::size_t i = 0; i < count_; ++i)
    if (!at(i).final && at(i).slot == slot) finalize(map, at(i));
}

bool SealedTrajectory::take(std::vector<StampedPose>& out, std::size_t most) {
  out.clear();
  while (count_ > 0 && at(0).final && out.size() < most) {
    out.push_back({at(0).time, quantize(at(0).pose)});
    first_ = (first_ + 1) % ring_.size();
    --count_;
  }
  return !out.empty();
}

}  // namespace onemap::mapping
