#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "hal/frame.hpp"
#include "landmark_map.hpp"
#include "mapping/local/organized_cloud.hpp"

namespace onemap::mapping {

// The reference keyframe's depth as an organised cloud, ICP's target: as it was seen while it is the newest keyframe,
// later restored from what a keyframe keeps. Memory is taken in the constructor.
class ReferenceCloud {
 public:
  ReferenceCloud(const hal::Intrinsics& intrinsics, const hal::DepthNoise& noise);
  // That nobody keeps. T_colour_depth: see FrontEnd.
  void look(std::span<const std::uint16_t> depth, const std::optional<Pose>& T_colour_depth = {});
  // A new keyframe's depth image; the keyframe keeps its grid.
  void see(std::span<const std::uint16_t> depth, const std::optional<Pose>& T_colour_depth, MapKeyframe& keyframe);
  void restore(const MapKeyframe& keyframe);
  const OrganizedCloud& cloud() const { return is_seen_ ? seen_ : restored_; }
  std::size_t bytes() const;

 private:
  hal::Intrinsics intrinsics_;
  OrganizedCloud seen_, restored_;  // two, because each keeps the sampling pattern of its source
  bool is_seen_ = true;
};

}  // namespace onemap::mapping
