#include "sensor.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::hal::simulated {

namespace {

// Kinect v1: pattern and infrared camera 7.5 cm apart, 580 px focal length, disparity in eighths of a pixel.
constexpr double kBaseline = 0.075, kStepsPerInverseMetre = 8 * kBaseline * 580;
constexpr double kSigmaSteps = 0.5, kUnitsPerMetre = 5000;
constexpr std::size_t kGauss = 1 << 16;
constexpr std::size_t kSteps = 1024;  // 348 steps at 1 m; nearer than 0.34 m all is out of range

// How much darker the picture is towards its edges, as a share of 65536.
std::vector<std::uint16_t> fade(int pixels, int copies, double loss) {
  std::vector<std::uint16_t> out;
  for (int i = 0; i < pixels; ++i) {
    const double off = (i - (pixels - 1) / 2.0) / (pixels / 2.0);
    out.insert(out.end(), static_cast<std::size_t>(copies), static_cast<std::uint16_t>(65535 * (1 - loss * off * off)));
  }
  return out;
}

// The sum of twelve uniform numbers has variance 1.
std::vector<std::int16_t> gauss_table(std::size_t size) {
  std::vector<std::int16_t> out(size);
  Random random(2);
  for (std::int16_t& value : out) {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform();
    value = static_cast<std::int16_t>(1024 * sum);
  }
  return out;
}

}  // namespace

Sensor::Sensor(const Options& options)
    : options_(options),
      width_(static_cast<std::size_t>(options.width)),
      pattern_px_(static_cast<float>(kBaseline * options.intrinsics().fx)),
      key_(hash(hash(options.seed, 31), static_cast<std::uint64_t>(options.robot))),
      depth_of_(kSteps),
      fade_x_(fade(options.width, 3, .13)),
      fade_y_(fade(options.height, 1, .10)),
      blurred_(3 * 3 * width_) {
  if (options.kinect_noise) gauss_ = gauss_table(kGauss + 3 * width_);
  for (std::size_t steps = 1; steps < kSteps; ++steps) {
    const double z = kStepsPerInverseMetre / static_cast<double>(steps);
    if (z >= options.near_m && z <= options.far_m)
      depth_of_[steps] = static_cast<std::uint16_t>(std::lround(z * kUnitsPerMetre));
  }
}

const std::int16_t* Sensor::noise(std::uint64_t frame, int y, std::uint64_t which) const {
  const std::uint64_t counter = frame * 4096 + static_cast<std::uint64_t>(y) * 2 + which;
  return gauss_.data() + hash(key_, counter) % kGauss;
}

void Sensor::take(std::uint64_t frame, int y, const Row& row, std::span<std::uint8_t> rgb,
                  std::span<std::uint16_t> depth) {
  const std::size_t at = static_cast<std::size_t>(y) * width_;
  if (!options_.kinect_noise) {
    exact_depth(row, depth.data() + at);
    std::copy(row.rgb.begin(), row.rgb.end(), rgb.data() + 3 * at);
    return;
  }
  kinect_depth(row, noise(frame, y, 0), depth.data() + at);
  const auto slot = [&](int line) { return blurred_.data() + static_cast<std::size_t>(line % 3) * 3 * width_; };
  blur_along(row, slot(y));
  if (y > 0) deliver_colour(frame, y - 1, std::max(0, y - 2), y, rgb.data() + 3 * (at - width_));
  if (y == options_.height - 1) deliver_colour(frame, y, y - 1, y, rgb.data() + 3 * at);
}

void Sensor::exact_depth(const Row& row, std::uint16_t* depth) const {
  for (std::size_t x = 0; x < width_; ++x) {
    const float w = row.inverse_depth[x];
    const float units = w > 0 ? static_cast<float>(kUnitsPerMetre) / w + 0.5f : 0.0f;
    depth[x] = units < 65536.0f ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
  }
}

void Sensor::kinect_depth(const Row& row, const std::int16_t* noise, std::uint16_t* depth) const {
  constexpr auto kSteps_m = static_cast<float>(kStepsPerInverseMetre);
  constexpr auto kSigma = static_cast<float>(kSigmaSteps / 1024);
  float lit =
      -1e9f;  // the rightmost place, on the pattern, of what was seen to the left: it hides the pattern behind it
  for (std::size_t x = 0; x < width_; ++x) {
    const float w = row.inverse_depth[x], unrest = static_cast<float>(noise[x]);
    const float place = static_cast<float>(x) + pattern_px_ * w;
    const bool shadow = place < lit - 1.0f + 0.0003f * unrest;
    lit = std::max(lit, place);
    const float unrounded = kSteps_m * w + kSigma * unrest + 0.5f;
    const int steps = static_cast<int>(unrounded);  // below 1, rounding does not matter: there is no reading
    const bool none = shadow || row.weak[x] != 0 || steps < 1 || steps >= static_cast<int>(kSteps);
    depth[x] = none ? std::uint16_t{0} : depth_of_[static_cast<std::size_t>(steps)];
  }
}

// [1 6 1] along the row, the ends repeated.
void Sensor::blur_along(const Row& row, std::uint16_t* out) const {
  const std::uint8_t* p = row.rgb.data();
  const std::size_t n = 3 * width_;
  for (std::size_t i = 3; i + 3 < n; ++i) out[i] = static_cast<std::uint16_t>(p[i - 3] + 6 * p[i] + p[i + 3]);
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = static_cast<std::uint16_t>(7 * p[i] + p[i + 3]);
    out[n - 1 - i] = static_cast<std::uint16_t>(7 * p[n - 1 - i] + p[n - 4 - i]);
  }
}

// [1 6 1] across the rows, vignetting, noise of 1.6 levels; in 1/128 levels.
void Sensor::deliver_colour(std::uint64_t frame, int y, int above, int below, std::uint8_t* rgb) const {
  const std::size_t n = 3 * width_;
  const std::uint16_t* a = blurred_.data() + static_cast<std::size_t>(above % 3) * n;
  const std::uint16_t* b = blurred_.data() + static_cast<std::size_t>(y % 3) * n;
  const std::uint16_t* c = blurred_.data() + static_cast<std::size_t>(below % 3) * n;
  const std::int16_t* grain = noise(frame, y, 1);
  const std::uint32_t fade_y = fade_y_[static_cast<std::size_t>(y)];
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t sum = 2u * (a[i] + 6u * b[i] + c[i]);
    const auto faded = static_cast<std::int32_t>((((sum * fade_x_[i]) >> 16) * fade_y) >> 16);
    const std::int32_t value = (faded + ((grain[i] * 51) >> 8) + 64) >> 7;
    rgb[i] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
  }
}

}  // namespace onemap::hal::simulated
