#include "by_lines.hpp"

#include <algorithm>

#include "hal/lens.hpp"
#include "nearest.hpp"

namespace onemap::hal::imaging {

bool ByLines::suits(const Intrinsics& depth, const Intrinsics& colour, const ColourFromDepth& pose) {
  return pose.rotation == ColourFromDepth().rotation && pose.translation_m[1] == 0 && pose.translation_m[2] == 0 &&
         !has_distortion(depth) && !has_distortion(colour);
}

ByLines::ByLines(const footprints::Rig& rig, const Intrinsics& depth)
    : rig_{.column = {},
           .metres = rig.metres,
           .offset_m = rig.offset_m,
           .shift = rig.lens.fx * rig.t_m[0],
           .half = 0.5f * rig.finer_u + footprints::kMargin_px,
           .scale = rig.scale,
           .nearest_m = rig.nearest_m,
           .too_far = rig.too_far,
           .least = rig.least,
           .columns = rig.width},
      width_(static_cast<std::size_t>(depth.width)),
      most_(static_cast<std::size_t>(2 * rig_.half) + 1),
      covered_(width_),
      line_(static_cast<std::size_t>(rig.width)),
      simd_(simd_available()) {
  for (int u = 0; u < depth.width; ++u)
    rig_.column.push_back(rig.lens.fx * static_cast<float>((u - depth.cx) / depth.fx) + rig.lens.cx);
  const float half_v = 0.5f * rig.finer_v + footprints::kMargin_px;
  for (int v = 0; v < depth.height; ++v) {
    const float middle = rig.lens.fy * static_cast<float>((v - depth.cy) / depth.fy) + rig.lens.cy;
    std::int32_t first = 0, end = 0;
    footprints::centres_around(middle, half_v, static_cast<float>(rig.height), first, end);
    if (end - first > footprints::kWidest_px) end = first;
    rows_.push_back({static_cast<std::size_t>(first), static_cast<std::size_t>(end)});
  }
}

DepthRegistration::Counts ByLines::apply(std::span<const std::uint16_t> depth, std::uint16_t* registered) {
  const auto merge = simd_ ? sideways::merge_simd : sideways::merge_plain;
  DepthRegistration::Counts counts;
  for (std::size_t v = 0; v < rows_.size(); ++v) {
    const auto row = depth.subspan(v * width_, width_);
    const auto [first, end] = rows_[v];
    if (first == end) {
      counts.add_unseen(row);
      continue;
    }
    (simd_ ? sideways::find_simd : sideways::find_plain)(rig_, row, covered_);
    counts.readings += static_cast<std::uint64_t>(covered_.readings);
    counts.outside += static_cast<std::uint64_t>(covered_.readings - covered_.seen);
    std::ranges::fill(line_, nearest::kNothing);
    sideways::keep(covered_, most_, line_.data());
    for (std::size_t at = first; at < end; ++at) merge(line_.data(), line_.size(), registered + at * line_.size());
  }
  return counts;
}

}  // namespace onemap::hal::imaging
