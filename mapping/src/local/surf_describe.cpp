#include <algorithm>
#include <array>
#include <cmath>

#include "surf_internal.hpp"
#include "twin.hpp"

namespace onemap::mapping::surf {

namespace {

int rounded(float v) { return static_cast<int>(std::lround(v)); }

constexpr int kSamples = 24;            // gradient samples a side, s apart
constexpr int kLattice = kSamples + 1;  // box means between which the gradients are taken
constexpr int kRow = 32;                // lattice row in memory

// Weight of sample i for cell c: cells of 9 samples, 5 apart, so neighbours overlap (Agrawal, Konolige, Blas 2008); a
// Gaussian of 2.5 samples about the cell's centre times one of 1.5 cells about the window's.
struct Weights {
  float w[4][kSamples];
};
// exp(-t^2 / 2) by its series at compile time.
constexpr double gauss(double t) {
  const double x = t * t / 2;
  double term = 1, sum = 1;
  for (int k = 1; k < 40; ++k) {
    term *= x / k;
    sum += term;
  }
  return 1 / sum;
}
constexpr Weights make_weights() {
  Weights out{};
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < kSamples; ++i) {
      const double centre = 4 + 5 * c + 0.0, d = i - centre - 0.0;
      if (d < -4.5 || d > 4.5) continue;
      out.w[c][i] = static_cast<float>(gauss(d / 2.5) * gauss((c - 1.5) / 1.5));
    }
  return out;
}
constexpr Weights kWeights = make_weights();

struct Window {
  const std::uint32_t* sums;
  int stride, box, max_x, max_y;  // box side; largest corner such that the box fits
  float x, y, step_x, step_y;     // of lattice point (0, 0)'s box corner, plus half a pixel; step along a lattice row
};

// Sums of boxes at the points of the turned lattice, clamped into the image.
ONEMAP_TWIN_BODY void sample_body(const Window& w, float* __restrict patch) {
  const float max_x = static_cast<float>(w.max_x), max_y = static_cast<float>(w.max_y);
  alignas(32) int index[kRow];
  for (int j = 0; j < kLattice; ++j) {
    const float row_x = w.x - static_cast<float>(j) * w.step_y, row_y = w.y + static_cast<float>(j) * w.step_x;
    for (int i = 0; i < kRow; ++i) {
      float px = row_x + static_cast<float>(i) * w.step_x, py = row_y + static_cast<float>(i) * w.step_y;
      px = px < 0.f ? 0.f : px;
      py = py < 0.f ? 0.f : py;
      px = px > max_x ? max_x : px;
      py = py > max_y ? max_y : py;
      index[i] = static_cast<int>(py) * w.stride + static_cast<int>(px);
    }
    const std::uint32_t* right = w.sums + w.box;
    const std::uint32_t* below = w.sums + w.box * w.stride;
    const std::uint32_t* both = below + w.box;
    float* out = patch + j * kRow;
    for (int i = 0; i < kRow; ++i)
      out[i] = static_cast<float>(
          static_cast<std::int32_t>(both[index[i]] - below[index[i]] - right[index[i]] + w.sums[index[i]]));
  }
}

struct Columns {
  float v[4][4][kSamples];  // [cell row][dx, |dx|, dy, |dy|][column]
};

// Gradients in the turned frame, summed over the rows of each row of cells.
ONEMAP_TWIN_BODY void sum_rows_body(const float* patch, Columns& columns) {
  for (int j = 0; j < kSamples; ++j) {
    const float *upper = patch + j * kRow, *lower = upper + kRow;
    float g[4][kSamples];
    for (int i = 0; i < kSamples; ++i) {
      const float falling = lower[i + 1] - upper[i], rising = upper[i + 1] - lower[i];
      const float dx = falling + rising, dy = falling - rising;
      g[0][i] = dx;
      g[1][i] = dx < 0 ? -dx : dx;
      g[2][i] = dy;
      g[3][i] = dy < 0 ? -dy : dy;
    }
    for (int c = 0; c < 4; ++c) {
      const float weight = kWeights.w[c][j];
      if (weight == 0) continue;
      for (int k = 0; k < 4; ++k)
        for (int i = 0; i < kSamples; ++i) columns.v[c][k][i] += weight * g[k][i];
    }
  }
}

ONEMAP_TWIN_BODY void sum_window_body(const Window& window, Columns& columns) {
  alignas(32) float patch[kLattice * kRow];
  sample_body(window, patch);
  sum_rows_body(patch, columns);
}
ONEMAP_TWIN(sum_window, (const Window& window, Columns& columns), (window, columns))

void quantise(const float (&v)[64], Descriptor& out) {
  float length2 = 1e-12f;
  for (const float c : v) length2 += c * c;
  const float factor = 127.f / std::sqrt(length2);
  for (std::size_t i = 0; i < 64; ++i) {
    const float c = v[i] * factor;
    out.v[i] = static_cast<std::int8_t>(std::clamp(static_cast<int>(c < 0 ? c - 0.5f : c + 0.5f), -127, 127));
  }
}

}  // namespace

void describe(const IntegralImage& integral, float x_px, float y_px, float scale, Direction direction, bool simd,
              Descriptor& out) {
  const int box = std::max(1, rounded(scale));
  const float c = direction.cos * scale, s = direction.sin * scale;
  // The lattice is centred on the feature; a box about point p starts at p - (box - 1) / 2.
  constexpr float kHalf = 0.5f * static_cast<float>(kSamples);
  const float corner = 0.5f * static_cast<float>(box - 1);
  const Window window{integral.sums.data(),
                      integral.stride,
                      box,
                      integral.width - box,
                      integral.height - box,
                      x_px + 0.5f - corner - kHalf * c + kHalf * s,
                      y_px + 0.5f - corner - kHalf * s - kHalf * c,
                      c,
                      s};
  Columns columns{};
  (simd ? sum_window_simd : sum_window_plain)(window, columns);
  float v[64];
  for (int row = 0; row < 4; ++row)
    for (int cell = 0; cell < 4; ++cell)
      for (int k = 0; k < 4; ++k) {
        float sum = 0;
        for (int i = 0; i < kSamples; ++i) sum += kWeights.w[cell][i] * columns.v[row][k][i];
        v[(row * 4 + cell) * 4 + k] = sum;
      }
  quantise(v, out);
}

}  // namespace onemap::mapping::surf
