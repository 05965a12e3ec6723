#pragma once
#include <cstdint>
#include <vector>

#include "landmark_map.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::mapping {

// Tracked frames on their way out. A frame is kept relative to its reference keyframe until that keyframe's pose is
// final.
class SealedTrajectory {
 public:
  explicit SealedTrajectory(std::size_t capacity);
  void add(const LandmarkMap& map, FrameTime time, std::size_t reference_slot, const Pose& T_reference_camera);
  void seal(const LandmarkMap& map, std::size_t slot);  // that keyframe will not move any more
  // Oldest first, at most most; false when the oldest frame is not final yet.
  bool take(std::vector<StampedPose>& out, std::size_t most);
  std::size_t bytes() const { return ring_.size() * sizeof(Entry); }

 private:
  struct Entry {
    FrameTime time{};
    std::size_t slot = 0;
    bool final = false;
    Pose pose;  // T_reference_camera, or T_robot_camera once final
  };
  void finalize(const LandmarkMap& map, Entry& e);
  Entry& at(std::size_t i) { return ring_[(first_ + i) % ring_.size()]; }
  std::vector<Entry> ring_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace onemap::mapping
