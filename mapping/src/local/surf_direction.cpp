#include <algorithm>
#include <array>
#include <cmath>

#include "surf_internal.hpp"
#include "twin.hpp"

namespace onemap::mapping::surf {

namespace {

constexpr int kRadius = 5;                    // samples at multiples of s, less than 6 s away
constexpr int kSide = 2 * kRadius + 1;        // of the square of samples
constexpr int kReach = 2;                     // of a wavelet from its sample: its side is 4 s
constexpr int kCorners = kSide + 2 * kReach;  // lattice of the wavelets' corners
constexpr int kRow = 16;                      // samples a row in memory
constexpr int kCornerRow = kRow + 2 * kReach;
constexpr int kBins = 72;
constexpr int kSector = kBins / 3;  // wider than the paper's 60 degrees: steadier on the recordings

// exp(-i^2 / (2 2.5^2)) for i = 0 .. 5: the Gaussian of a sample is the product of its column's and its row's.
constexpr std::array<float, 6> kGauss = {1.f, 0.923116346f, 0.726149037f, 0.486752256f, 0.278037300f, 0.135335283f};

struct Samples {
  alignas(32) float weight[kSide * kRow];
};
constexpr Samples make_samples() {
  Samples out{};
  for (int j = -kRadius; j <= kRadius; ++j)
    for (int i = -kRadius; i <= kRadius; ++i)
      if (i * i + j * j < (kRadius + 1) * (kRadius + 1))
        out.weight[(j + kRadius) * kRow + i + kRadius] =
            kGauss[static_cast<std::size_t>(i < 0 ? -i : i)] * kGauss[static_cast<std::size_t>(j < 0 ? -j : j)];
  return out;
}
constexpr Samples kSamples = make_samples();

struct Gradients {
  alignas(32) float x[kSide * kRow];
  alignas(32) float y[kSide * kRow];
  alignas(32) std::int32_t bin[kSide * kRow];
};

// Angle of (x, y) as a bin in 0 .. kBins, by a polynomial: no libm, so the same on every machine.
ONEMAP_TWIN_BODY std::int32_t direction_bin(float x, float y) {
  const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const float big = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
  const float t = small / (big + 1e-20f), t2 = t * t;
  float turn = t * (0.15886f + t2 * (-0.04960f + t2 * 0.01570f));  // atan(t) / (2 pi), error < 4e-4
  turn = ay > ax ? 0.25f - turn : turn;
  turn = x < 0 ? 0.5f - turn : turn;
  turn = y < 0 ? 1.f - turn : turn;
  return static_cast<std::int32_t>(turn * static_cast<float>(kBins));
}

// Haar wavelets of side 4 s at every s; their corners are a lattice of the integral image.
ONEMAP_TWIN_BODY void wavelets_body(const std::int32_t* corners, Gradients& out) {
  for (int j = 0; j < kSide; ++j) {
    const std::int32_t* upper = corners + j * kCornerRow;
    const std::int32_t* middle = upper + kReach * kCornerRow;
    const std::int32_t* lower = middle + kReach * kCornerRow;
    const float* weight = kSamples.weight + j * kRow;
    for (int i = 0; i < kRow; ++i) {
      const std::int32_t left = lower[i + 2] - lower[i] - upper[i + 2] + upper[i];
      const std::int32_t right = lower[i + 4] - lower[i + 2] - upper[i + 4] + upper[i + 2];
      const std::int32_t top = middle[i + 4] - middle[i] - upper[i + 4] + upper[i];
      const std::int32_t bottom = lower[i + 4] - lower[i] - middle[i + 4] + middle[i];
      const float x = weight[i] * static_cast<float>(right - left), y = weight[i] * static_cast<float>(bottom - top);
      out.x[j * kRow + i] = x;
      out.y[j * kRow + i] = y;
      out.bin[j * kRow + i] = direction_bin(x, y);
    }
  }
}

// sums[i] = sum of bins i .. i + kSector - 1, around the circle, by doubling: 8 and then 24 bins.
ONEMAP_TWIN_BODY void sector_sums(const float* bins, float* __restrict sums) {
  constexpr int kRound = kBins + kSector;
  alignas(32) float a[kRound + 8], b[kRound + 8];
  for (int i = 0; i < kRound + 8; ++i) a[i] = bins[i < kBins ? i : i - kBins];
  for (int i = 0; i < kRound + 7; ++i) b[i] = a[i] + a[i + 1];
  for (int i = 0; i < kRound + 5; ++i) a[i] = b[i] + b[i + 2];
  for (int i = 0; i < kRound; ++i) b[i] = a[i] + a[i + 4];
  static_assert(kSector == 24);
  for (int i = 0; i < kBins; ++i) sums[i] = b[i] + b[i + 8] + b[i + 16];
}

struct Vector {
  float x, y;
};

ONEMAP_TWIN_BODY void dominant_body(const std::int32_t* corners, Vector& out) {
  Gradients g;
  wavelets_body(corners, g);
  float bins_x[kBins + 1] = {}, bins_y[kBins + 1] = {};  // the last: angles that round up to a full turn
  for (int j = 0; j < kSide; ++j)
    for (int k = j * kRow; k < j * kRow + kSide; ++k) {
      bins_x[g.bin[k]] += g.x[k];
      bins_y[g.bin[k]] += g.y[k];
    }
  bins_x[0] += bins_x[kBins];
  bins_y[0] += bins_y[kBins];
  float sum_x[kBins], sum_y[kBins];
  sector_sums(bins_x, sum_x);
  sector_sums(bins_y, sum_y);
  float best = 0;
  out = {1, 0};
  for (int i = 0; i < kBins; ++i) {
    const float length2 = sum_x[i] * sum_x[i] + sum_y[i] * sum_y[i];
    if (length2 > best) {
      best = length2;
      out = {sum_x[i], sum_y[i]};
    }
  }
}
ONEMAP_TWIN(dominant, (const std::int32_t* corners, Vector& out), (corners, out))

int rounded(float v) { return static_cast<int>(std::lround(v)); }

}  // namespace

Direction dominant_direction(const IntegralImage& integral, float x_px, float y_px, float scale, bool simd) {
  const int s = std::max(1, rounded(scale));
  const int x = rounded(x_px) - (kRadius + kReach) * s, y = rounded(y_px) - (kRadius + kReach) * s;
  alignas(32) std::int32_t corners[kCorners * kCornerRow];
  std::array<int, kCornerRow> column{};
  for (int i = 0; i < kCornerRow; ++i)
    column[static_cast<std::size_t>(i)] = std::clamp(x + std::min(i, kCorners - 1) * s, 0, integral.width);
  for (int j = 0; j < kCorners; ++j) {
    const std::uint32_t* row = integral.row(std::clamp(y + j * s, 0, integral.height));
    for (int i = 0; i < kCornerRow; ++i)
      corners[j * kCornerRow + i] = static_cast<std::int32_t>(row[column[static_cast<std::size_t>(i)]]);
  }
  Vector v{1, 0};
  (simd ? dominant_simd : dominant_plain)(corners, v);
  const float length = std::sqrt(v.x * v.x + v.y * v.y);
  return {v.x / length, v.y / length};
}

}  // namespace onemap::mapping::surf
