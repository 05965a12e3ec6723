#include "reference_cloud.hpp"

#include <vector>

#include "keyframe_record.hpp"

namespace onemap::mapping {

ReferenceCloud::ReferenceCloud(const hal::Intrinsics& intrinsics, const hal::DepthNoise& noise)
    : intrinsics_(intrinsics) {
  seen_.noise = restored_.noise = noise;
  // The first call of each takes its memory.
  const std::vector<std::uint16_t> no_depth(static_cast<std::size_t>(intrinsics.width) *
                                            static_cast<std::size_t>(intrinsics.height));
  MapKeyframe none;
  see(no_depth, {}, none);
  restore(none);
  is_seen_ = true;
}

void ReferenceCloud::look(std::span<const std::uint16_t> depth, const std::optional<Pose>& T_colour_depth) {
  organize(depth, intrinsics_, kGridWidth, kGridHeight, seen_, T_colour_depth);
  is_seen_ = true;
}

void ReferenceCloud::see(std::span<const std::uint16_t> depth, const std::optional<Pose>& T_colour_depth,
                         MapKeyframe& keyframe) {
  look(depth, T_colour_depth);
  store_grid(seen_, keyframe);
}

void ReferenceCloud::restore(const MapKeyframe& keyframe) {
  grid_cloud(keyframe, restored_);
  is_seen_ = false;
}

std::size_t ReferenceCloud::bytes() const {
  const auto of = [](const OrganizedCloud& c) {
    return c.points.size() * (2 * sizeof(Vector3f) + sizeof(OrganizedCloud::Sampling) + sizeof(float));
  };
  return of(seen_) + of(restored_);
}

}  // namespace onemap::mapping
