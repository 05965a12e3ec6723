#include "front_end.hpp"

#include "mapping/image.hpp"

namespace onemap::mapping {

namespace {

std::size_t pixels(const hal::Intrinsics& k) {
  return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
}

std::size_t most_points(const FrontEndConfig& config, const hal::Intrinsics& k) {
  const auto count = [&](int side_px) {
    return static_cast<std::size_t>((side_px + config.cloud_stride_px - 1) / config.cloud_stride_px);
  };
  return count(k.width) * count(k.height);
}

// A covered lens gives black, or what is not a picture at all; the barest wall has light and the sensor's noise.
bool shows_something(std::span<const std::uint8_t> gray) {
  constexpr std::size_t kStep = 211;  // prime: no column of pixels
  constexpr std::uint64_t kDarkest = 16;
  std::uint64_t n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < gray.size(); i += kStep, ++n) {
    sum += gray[i];
    squares += std::uint64_t{gray[i]} * gray[i];
  }
  return sum >= kDarkest * n && n * squares >= sum * sum + n * n;  // the variance is at least 1
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndConfig& config, const hal::Intrinsics& k)
    : config_(config),
      intrinsics_(k),
      rays_(k),
      gray_(pixels(k)),
      raw_points_(most_points(config, k)),
      voxel_grid_(config.cloud_leaf_m, raw_points_.size()) {
  if (config.features == DescriptorKind::surf) {
    SurfConfig surf;
    surf.max_features = config.max_features;
    surf_.emplace(surf, k.width, k.height);
  } else {
    orb_.emplace(OrbConfig{config.max_features}, k.width, k.height);
  }
}

Observed FrontEnd::make_observed() const {
  Observed out;
  out.features.reserve(static_cast<std::size_t>(config_.max_features));
  out.features.set.kind = config_.features;
  out.cloud.reserve(raw_points_.size());
  return out;
}

void FrontEnd::observe(const hal::FrameView& frame, const StepHook& begin, Observed& out,
                       const std::optional<Pose>& T_colour_depth) {
  out.time = frame.colour_time;
  out.depth_time = frame.depth_time;
  out.T_colour_depth = T_colour_depth;
  detect(frame, begin, T_colour_depth, out.features);
  out.lens_open = shows_something(gray_);
  begin(Step::cloud);
  sample_cloud(frame, T_colour_depth, out.cloud);
}

// Local features of the grey image, and eq. (5) for each.
void FrontEnd::detect(const hal::FrameView& frame, const StepHook& begin, const std::optional<Pose>& T_colour_depth,
                      FeatureFrame& out) {
  begin(Step::gray);
  to_gray(frame.rgb, gray_);
  begin(Step::features);
  const GrayView view{gray_.data(), intrinsics_.width, intrinsics_.height, intrinsics_.width};
  if (surf_)
    surf_->detect(view, out.set);
  else
    orb_->detect(view, out.set);
  attach_geometry(out, frame.depth, rays_, intrinsics_, T_colour_depth);
}

// Eq. (5) for every stride-th pixel, and figure 7.
void FrontEnd::sample_cloud(const hal::FrameView& frame, const std::optional<Pose>& T_colour_depth,
                            std::vector<Vector3f>& out) {
  const PointSampling sampling{config_.cloud_stride_px, config_.cloud_far_m};
  const std::size_t n = to_points(frame.depth, rays_, intrinsics_.depth_scale, sampling, raw_points_);
  out.resize(n);
  out.resize(voxel_grid_.downsample({raw_points_.data(), n}, out));
  if (!T_colour_depth) return;
  const Eigen::Matrix3f R = T_colour_depth->R.cast<float>();
  const Vector3f t = T_colour_depth->t.cast<float>();
  for (Vector3f& p : out) p = R * p + t;
}

std::size_t FrontEnd::bytes() const {
  return rays_.bytes() + gray_.capacity() + (surf_ ? surf_->bytes() : 0) + raw_points_.capacity() * sizeof(Vector3f) +
         voxel_grid_.bytes();
}

}  // namespace onemap::mapping
