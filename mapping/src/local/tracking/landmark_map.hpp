#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "feature_frame.hpp"
#include "mapping/local/submap_anchor.hpp"
#include "pose_refiner.hpp"

namespace onemap::mapping {

// A point that several keyframes see.
struct Landmark {
  Vector3d p_robot = Vector3d::Zero();  // robot's own frame
  Descriptor descriptor;                // as the last keyframe saw it
  std::int8_t laplacian = 0;
  std::uint16_t observations = 0;        // keyframes that see it
  std::uint32_t visible = 0, found = 0;  // frames in which it should have been, and was, seen
  std::uint32_t mark = 0;                // scratch of whoever walks the map, see LandmarkMap::next_mark
  std::int32_t slot = -1;                // scratch: index within the walk
  bool used = false;
};

struct MapKeyframe {
  bool used = false;
  bool sealed = false;      // left the optimisation window: its pose is final
  std::uint32_t index = 0;  // the robot's count
  FrameTime time{};
  Pose T_camera_robot;
  std::optional<PosePrior> depth;  // what depth says of the pose, of a keyframe that depth placed
  SubmapAnchor anchor;             // the keyframe, itself or an earlier one, into whose submap frames near it are fused
  FeatureFrame features;
  std::vector<std::uint16_t> grid_depth;  // kGridWidth x kGridHeight, units of 0.25 mm, 0 = none
  double grid_fx = 0, grid_fy = 0, grid_cx = 0, grid_cy = 0;
};

inline constexpr int kGridWidth = 160, kGridHeight = 120;

// Keyframes and landmarks in pools of fixed size, whose memory is taken in the constructor. Slots are reused; the
// robot's keyframe count goes on. A keyframe is open (its pose still moves), then sealed and waiting to be taken, then
// taken; taken ones are evicted first, waiting ones only when there is no other, open ones never.
class LandmarkMap {
 public:
  LandmarkMap(std::size_t max_keyframes, std::size_t max_landmarks, std::size_t max_features);

  std::size_t keyframe_capacity() const { return keyframes_.size(); }
  MapKeyframe& keyframe(std::size_t slot) { return keyframes_[slot]; }
  const MapKeyframe& keyframe(std::size_t slot) const { return keyframes_[slot]; }
  Landmark& landmark(std::int32_t id) { return landmarks_[static_cast<std::size_t>(id)]; }
  const Landmark& landmark(std::int32_t id) const { return landmarks_[static_cast<std::size_t>(id)]; }

  void seal(std::size_t slot);
  const MapKeyframe* take_sealed();  // the one that waits longest, once; nullptr when none waits

  // A free keyframe slot, evicting the sealed keyframe with the least own landmarks when there is none (never those in
  // keep). At least one must be free, or sealed and not in keep.
  std::size_t take_keyframe_slot(std::span<const std::size_t> keep);
  // Evicts sealed keyframes until so many landmarks can be added (or nothing is left to evict).
  void make_room(std::size_t landmarks, std::span<const std::size_t> keep);
  std::int32_t add_landmark();                              // -1 when the pool is full
  void unlink(MapKeyframe& keyframe, std::size_t feature);  // the landmark goes when nobody sees it any more
  std::uint64_t evicted() const { return evicted_; }
  std::uint64_t evicted_untaken() const { return evicted_untaken_; }  // of these, before anybody took them
  std::uint32_t next_mark() { return ++mark_; }
  std::size_t bytes() const;

  // Slots of the keyframes that see at least min_shared landmarks carrying this mark, most first, at most out.size().
  std::size_t covisible(std::uint32_t mark, int min_shared, std::span<std::size_t> out) const;

 private:
  void evict(std::size_t slot);
  bool waits(std::size_t slot) const;
  // The sealed keyframe with the least landmarks of its own, a taken one if there is; none: keyframe_capacity().
  std::size_t least_useful(std::span<const std::size_t> keep) const;
  std::vector<MapKeyframe> keyframes_;
  std::vector<Landmark> landmarks_;
  std::vector<std::int32_t> free_;
  std::vector<std::size_t> waiting_;  // slots of sealed keyframes that were not taken, oldest first
  std::uint64_t evicted_ = 0, evicted_untaken_ = 0;
  std::uint32_t mark_ = 0;
};

}  // namespace onemap::mapping
