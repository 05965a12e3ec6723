#include "mapping/local/focal_check.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::mapping {

namespace {

constexpr std::size_t kMostPoints = 120;  // of a pair of views: 7140 pairs of points
constexpr std::size_t kLeastPairs = 60;   // of points, that say something
constexpr double kTimesNoise = 6;
constexpr double kPixel = 1.0 / 525;  // of a matched feature, about
constexpr double kWidest = 1.1;       // of a logarithm: a factor of three; beyond are wrong matches
constexpr int kLeastViews = 8;
constexpr double kTolerated = 0.10, kSigmas = 4;

// Half of what two points say of c^2: lateral and depth distance, squared, and the variances.
struct Apart {
  double lateral, depth, lateral_variance, depth_variance;
};

Apart apart(const hal::DepthNoise& noise, const Vector3d& p, const Vector3d& q) {
  const Vector3d d = p - q;
  const auto variance = [&](const Vector3d& v) {
    const double sigma = noise.sigma_m(v.z());
    return sigma * sigma;
  };
  const auto across = [&](const Vector3d& v) {
    const double slope2 = v.head<2>().squaredNorm() / (v.z() * v.z());
    return slope2 * variance(v) + v.z() * v.z() * kPixel * kPixel;
  };
  const double lateral = d.head<2>().squaredNorm(), depth = d.z() * d.z();
  return {lateral, depth, 4 * lateral * (across(p) + across(q)), 4 * depth * (variance(p) + variance(q))};
}

template <class Values>
double median_of(Values first, Values last) {
  const auto middle = first + (last - first) / 2;
  std::nth_element(first, middle, last);
  return *middle;
}

}  // namespace

bool FocalEstimate::wrong() const {
  const double off = std::abs(std::log(ratio));
  return views >= kLeastViews && off > kTolerated && off > kSigmas * sigma;
}

FocalCheck::FocalCheck(std::size_t max_points, const hal::DepthNoise& noise)
    : max_points_(std::min(max_points, kMostPoints)), noise_(noise) {
  found_.reserve(max_points_ * max_points_ / 2);
}

void FocalCheck::add(std::span<const Vector3d> a, std::span<const Vector3d> b) {
  found_.clear();
  const std::size_t step =
      std::max<std::size_t>(1, (a.size() + max_points_ - 1) / std::max<std::size_t>(1, max_points_));
  for (std::size_t i = 0; i < a.size(); i += step) {
    for (std::size_t j = i + step; j < a.size(); j += step) {
      const Apart one = apart(noise_, a[i], a[j]), other = apart(noise_, b[i], b[j]);
      const double lateral = one.lateral - other.lateral, depth = other.depth - one.depth;
      const double variance = one.lateral_variance + other.lateral_variance + one.depth_variance + other.depth_variance;
      if (lateral * depth <= 0 || std::abs(lateral + depth) < kTimesNoise * std::sqrt(variance)) continue;
      const double off = 0.5 * std::log(depth / lateral);
      if (std::abs(off) < kWidest) found_.push_back(off);
    }
  }
  if (found_.size() < kLeastPairs) return;
  views_[added_++ % kViews] = median_of(found_.begin(), found_.end());
}

FocalEstimate FocalCheck::estimate() const {
  const std::size_t count = std::min(added_, kViews);
  if (count == 0) return {};
  std::array<double, kViews> values = views_;
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  const double middle = median_of(values.begin(), end);
  std::for_each(values.begin(), end, [&](double& v) { v = std::abs(v - middle); });
  // The deviation of a median of n, from the median deviation.
  const double sigma = 1.2533 * 1.4826 * median_of(values.begin(), end) / std::sqrt(static_cast<double>(count));
  return {std::exp(middle), sigma, static_cast<int>(count)};
}

}  // namespace onemap::mapping
