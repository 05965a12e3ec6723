#include "mapping/local/orb.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/features2d.hpp>

namespace onemap::mapping {

struct Orb::Impl {
  OrbConfig config;
  cv::Ptr<cv::ORB> orb;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  std::vector<std::size_t> order;
};

Orb::Orb(const OrbConfig& config, int /*width*/, int /*height*/) : impl_(std::make_unique<Impl>()) {
  impl_->config = config;
  impl_->orb = cv::ORB::create(config.max_features);
}
Orb::~Orb() = default;
Orb::Orb(Orb&&) noexcept = default;
Orb& Orb::operator=(Orb&&) noexcept = default;

void Orb::detect(const GrayView& image, FeatureSet& out) {
  Impl& m = *impl_;
  out.clear();
  out.kind = DescriptorKind::orb;
  // OpenCV has no view of constant pixels; detectAndCompute does not write to its input.
  const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data),
                     static_cast<std::size_t>(image.stride));
  m.orb->detectAndCompute(grey, cv::noArray(), m.keypoints, m.descriptors);
  m.order.resize(m.keypoints.size());
  for (std::size_t i = 0; i < m.order.size(); ++i) m.order[i] = i;
  std::stable_sort(m.order.begin(), m.order.end(),
                   [&](std::size_t a, std::size_t b) { return m.keypoints[a].response > m.keypoints[b].response; });
  // OpenCV may give a few more than asked for; the contract is max_features at most.
  m.order.resize(std::min(m.order.size(), static_cast<std::size_t>(m.config.max_features)));
  for (const std::size_t i : m.order) {
    const cv::KeyPoint& k = m.keypoints[i];
    const double angle = k.angle * std::numbers::pi / 180;
    out.keypoints.push_back({k.pt.x, k.pt.y, k.size, static_cast<float>(std::cos(angle)),
                             static_cast<float>(std::sin(angle)), k.response, 0});
    std::memcpy(out.descriptors.emplace_back().v.data(), m.descriptors.ptr(static_cast<int>(i)), 32);
  }
}

}  // namespace onemap::mapping
