#include "guided_search.hpp"

#include <algorithm>

#include "mapping/local/match.hpp"

namespace onemap::mapping {

GuidedSearch::GuidedSearch(const hal::Intrinsics& k, std::size_t max_features)
    : fx_(k.fx),
      fy_(k.fy),
      cx_(k.cx),
      cy_(k.cy),
      width_(k.width),
      height_(k.height),
      columns_((k.width + kCell_px - 1) / kCell_px),
      rows_((k.height + kCell_px - 1) / kCell_px) {
  cell_begin_.reserve(static_cast<std::size_t>(columns_ * rows_) + 1);
  order_.reserve(max_features);
  pixel_.reserve(max_features);
  claim_.reserve(max_features);
  claim_distance_.reserve(max_features);
}

void GuidedSearch::index(const FeatureFrame& frame) {
  const std::size_t n = frame.size();
  pixel_.resize(n);
  order_.resize(n);
  cell_begin_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  auto cell_of = [&](std::size_t i) {
    const int column = std::clamp(static_cast<int>(pixel_[i].x()) / kCell_px, 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(pixel_[i].y()) / kCell_px, 0, rows_ - 1);
    return static_cast<std::size_t>(row * columns_ + column);
  };
  for (std::size_t i = 0; i < n; ++i) {
    pixel_[i] = {static_cast<float>(fx_ * frame.ray[i].x() + cx_), static_cast<float>(fy_ * frame.ray[i].y() + cy_)};
    ++cell_begin_[cell_of(i) + 1];
  }
  for (std::size_t c = 1; c < cell_begin_.size(); ++c)
    cell_begin_[c] = static_cast<std::uint16_t>(cell_begin_[c] + cell_begin_[c - 1]);
  // Counting sort from the back keeps the order of features within a cell and leaves cell_begin_ at the beginnings.
  for (std::size_t i = n; i > 0; --i) order_[--cell_begin_[cell_of(i - 1) + 1]] = static_cast<std::uint16_t>(i - 1);
  for (std::size_t c = 0; c + 1 < cell_begin_.size(); ++c) cell_begin_[c] = cell_begin_[c + 1];
  cell_begin_.back() = static_cast<std::uint16_t>(n);
}

void GuidedSearch::nearest(const Landmark& landmark, double u, double v, const SearchConfig& config,
                           const FeatureFrame& frame, int& feature, std::int32_t& distance) const {
  const double r = config.radius_px;
  const int c0 = std::max(0, static_cast<int>(u - r) / kCell_px),
            c1 = std::min(columns_ - 1, static_cast<int>(u + r) / kCell_px);
  const int r0 = std::max(0, static_cast<int>(v - r) / kCell_px),
            r1 = std::min(rows_ - 1, static_cast<int>(v + r) / kCell_px);
  std::int32_t best = config.max_distance + 1, second = config.max_distance + 1;
  feature = -1;
  for (int row = r0; row <= r1; ++row)
    for (int column = c0; column <= c1; ++column) {
      const auto cell = static_cast<std::size_t>(row * columns_ + column);
      for (std::size_t k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) {
        const std::size_t i = order_[k];
        const double du = pixel_[i].x() - u, dv = pixel_[i].y() - v;
        if (du * du + dv * dv > r * r || frame.set.keypoints[i].laplacian != landmark.laplacian) continue;
        const std::int32_t d = descriptor_distance(frame.set.descriptors[i], landmark.descriptor, frame.set.kind);
        if (d < best)
          second = best, best = d, feature = static_cast<int>(i);
        else if (d < second)
          second = d;
      }
    }
  const float squared_ratio =
      frame.set.kind == DescriptorKind::surf ? config.max_ratio * config.max_ratio : config.max_ratio;
  if (best > config.max_distance || static_cast<float>(best) > squared_ratio * static_cast<float>(second)) feature = -1;
  distance = best;
}

int GuidedSearch::find(LandmarkMap& map, std::span<const std::int32_t> ids, const Pose& T, const SearchConfig& config,
                       FeatureFrame& frame) {
  claim_.assign(frame.size(), -1);
  claim_distance_.assign(frame.size(), 0);
  expected_ = 0;
  for (const std::int32_t id : ids) {
    Landmark& l = map.landmark(id);
    const Vector3d p = T * l.p_robot;
    if (p.z() < kMinDepth_m) continue;
    const double u = fx_ * p.x() / p.z() + cx_, v = fy_ * p.y() / p.z() + cy_;
    if (u < 0 || v < 0 || u >= width_ || v >= height_) continue;
    ++l.visible;
    const double margin = kMargin * width_;
    expected_ += u >= margin && v >= margin && u < width_ - margin && v < height_ - margin;
    int feature = -1;
    std::int32_t distance = 0;
    nearest(l, u, v, config, frame, feature, distance);
    if (feature < 0) continue;
    const auto f = static_cast<std::size_t>(feature);
    if (frame.landmark[f] >= 0) continue;
    if (frame.has_depth(f) && std::abs(frame.point[f].z() - p.z()) > 0.05 + 0.03 * p.z() * p.z()) continue;
    if (claim_[f] >= 0 && claim_distance_[f] <= distance) continue;
    claim_[f] = id;
    claim_distance_[f] = distance;
  }
  int found = 0;
  for (std::size_t f = 0; f < frame.size(); ++f) {
    if (claim_[f] < 0) continue;
    frame.landmark[f] = claim_[f];
    ++found;
  }
  return found;
}

}  // namespace onemap::mapping
