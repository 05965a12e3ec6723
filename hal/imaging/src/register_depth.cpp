#include "hal/imaging/register_depth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "by_lines.hpp"
#include "by_rays.hpp"
#include "hal/imaging/image_size.hpp"
#include "nearest.hpp"

namespace onemap::hal::imaging {

namespace {

using footprints::Rig;

constexpr float kNearest_m = 0.01f;

Rig rig_of(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose, double offset_m) {
  const auto as_float = [](double value) { return static_cast<float>(value); };
  const auto scale = as_float(colour.depth_scale);
  const auto& t = pose.translation_m;
  return {.lens = footprints::ColourLens(colour),
          .t_m = {as_float(t[0]), as_float(t[1]), as_float(t[2])},
          .metres = as_float(1 / depth.depth_scale),
          .offset_m = as_float(offset_m),
          .scale = scale,
          .finer_u = as_float(colour.fx / depth.fx),
          .finer_v = as_float(colour.fy / depth.fy),
          .nearest_m = kNearest_m,
          .too_far = 65536,
          .least = std::max(1, static_cast<int>(std::lround(kNearest_m * scale)) + 1),
          .width = colour.width,
          .height = colour.height};
}

}  // namespace

struct DepthRegistration::Parts {
  Parts(const Intrinsics& depth_lens, const Intrinsics& colour_lens, const ColourFromDepth& pose, double offset_m)
      : depth(size_of(depth_lens)), colour(size_of(colour_lens)) {
    const Rig rig = rig_of(depth_lens, colour_lens, pose, offset_m);
    if (ByLines::suits(depth_lens, colour_lens, pose))
      lines.emplace(rig, depth_lens);
    else
      rays.emplace(rig, depth_lens, pose.rotation);
  }
  const ImageSize depth, colour;
  std::optional<ByLines> lines;  // one of the two
  std::optional<ByRays> rays;
};

DepthRegistration::DepthRegistration(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose,
                                     double offset_m)
    : parts_(std::make_unique<Parts>(depth, colour, pose, offset_m)) {}

DepthRegistration::~DepthRegistration() = default;

void DepthRegistration::Counts::add_unseen(std::span<const std::uint16_t> row) {
  const std::size_t some = row.size() - static_cast<std::size_t>(std::ranges::count(row, 0));
  readings += some;
  outside += some;
}

DepthRegistration::Counts DepthRegistration::apply(std::span<const std::uint16_t> depth,
                                                   std::span<std::uint16_t> registered) {
  Parts& p = *parts_;
  assert(depth.size() == p.depth.pixels() && registered.size() == p.colour.pixels());
  std::ranges::fill(registered, nearest::kNothing);
  const Counts counts = p.lines ? p.lines->apply(depth, registered.data()) : p.rays->apply(depth, registered.data());
  for (std::uint16_t& pixel : registered) ++pixel;  // nothing becomes 0
  return counts;
}

}  // namespace onemap::hal::imaging
