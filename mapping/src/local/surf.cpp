#include "mapping/local/surf.hpp"

#include <algorithm>
#include <cassert>

#include "surf_internal.hpp"

namespace onemap::mapping {

namespace {
constexpr int kLayers = 4;  // filter sizes an octave
constexpr std::size_t kMaxCandidates = 8192;

// 9 15 21 27, 15 27 39 51, 27 51 75 99, ...: the paper's sizes.
int filter_size(int octave, int layer) { return 3 * ((2 << octave) * (layer + 1) + 1); }
}  // namespace

struct Surf::Impl {
  SurfConfig config;
  bool simd;
  surf::IntegralImage integral;
  std::vector<surf::ResponseLayer> layers;  // octave by octave
  surf::RowScratch scratch;
  std::vector<std::uint8_t> row_mask;
  std::vector<surf::Candidate> candidates;
  surf::Spread spread;

  surf::ResponseLayer& layer(int octave, int i) {
    return layers[static_cast<std::size_t>(octave) * kLayers + static_cast<std::size_t>(i)];
  }
  void fill_octave(int octave);
  void append(const surf::Candidate& c, FeatureSet& out) const;
};

Surf::Surf(const SurfConfig& config, int width, int height) : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.config = config;
  m.simd = config.simd && surf::cpu_has_avx2();
  m.integral.resize(width, height);
  for (int octave = 0; octave < config.octaves; ++octave)
    for (int i = 0; i < kLayers; ++i) {
      surf::ResponseLayer layer{filter_size(octave, i), 1 << octave, 0, 0, {}};
      layer.width = (width + layer.step - 1) / layer.step;
      layer.height = (height + layer.step - 1) / layer.step;
      layer.values.assign(static_cast<std::size_t>(layer.width) * static_cast<std::size_t>(layer.height), 0.f);
      m.layers.push_back(std::move(layer));
    }
  const auto row = static_cast<std::size_t>(width) + 1;
  m.scratch = {std::vector<std::int32_t>(row), std::vector<std::int32_t>(row), std::vector<std::int32_t>(row)};
  m.row_mask.assign(row + 8, 0);
  m.candidates.reserve(kMaxCandidates);
  m.spread.reserve(width, height, kMaxCandidates);
}

Surf::~Surf() = default;
Surf::Surf(Surf&&) noexcept = default;
Surf& Surf::operator=(Surf&&) noexcept = default;

void Surf::Impl::fill_octave(int octave) {
  // The first two sizes of an octave are the second and the last of the octave below.
  int next = 0;
  if (octave > 0) {
    surf::subsample_layer(layer(octave - 1, 1), layer(octave, 0));
    surf::subsample_layer(layer(octave - 1, 3), layer(octave, 1));
    next = 2;
  }
  for (; next < kLayers; ++next) surf::fill_layer(integral, layer(octave, next), scratch, simd);
}

void Surf::Impl::append(const surf::Candidate& c, FeatureSet& out) const {
  surf::Direction direction{1, 0};
  if (!config.upright) direction = surf::dominant_direction(integral, c.x_px, c.y_px, c.scale, simd);
  out.keypoints.push_back({c.x_px, c.y_px, 20 * c.scale, direction.cos, direction.sin, c.response, c.laplacian});
  surf::describe(integral, c.x_px, c.y_px, c.scale, direction, simd, out.descriptors.emplace_back());
}

void Surf::detect(const GrayView& image, FeatureSet& out) {
  Impl& m = *impl_;
  assert(image.width == m.integral.width && image.height == m.integral.height);
  out.clear();
  out.kind = DescriptorKind::surf;
  m.integral.build(image);
  m.candidates.clear();
  for (int octave = 0; octave < m.config.octaves; ++octave) {
    m.fill_octave(octave);
    for (int i = 1; i + 1 < kLayers; ++i)
      surf::find_maxima(m.integral, std::span<const surf::ResponseLayer, 3>(&m.layer(octave, i - 1), 3),
                        m.config.hessian_threshold, m.row_mask, m.simd, m.candidates);
  }
  m.spread.select(static_cast<std::size_t>(m.config.max_features), m.candidates);
  for (const surf::Candidate& c : m.candidates) m.append(c, out);
}

std::size_t Surf::bytes() const {
  const Impl& m = *impl_;
  std::size_t total = sizeof(Impl) + m.integral.sums.capacity() * sizeof(std::uint32_t) + m.row_mask.capacity() +
                      3 * m.scratch.xx.capacity() * sizeof(std::int32_t) +
                      3 * kMaxCandidates * sizeof(surf::Candidate) + m.spread.taken.capacity() * sizeof(std::uint16_t);
  for (const auto& layer : m.layers) total += layer.values.capacity() * sizeof(float);
  return total;
}

}  // namespace onemap::mapping
