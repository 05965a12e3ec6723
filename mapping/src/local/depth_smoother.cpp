#include "mapping/local/depth_smoother.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "hal/base/twin.hpp"
#include "mapping/local/depth_range.hpp"

namespace onemap::mapping {
namespace {

// Inverse depth counts in eighths of the sensor's noise (1.7 mm at a metre: half a step of a Kinect's disparity, and
// its rounding), from a middle value on, so that squares stay small.
constexpr float kUnitsPerInverseMetre = 8 * 603;
constexpr float kMiddle = 1800;
constexpr float kSmoothed_m = 2.0f;    // from here on readings are smoothed,
constexpr float kAsked_m = 1.6f;       // and from here on they are asked
constexpr std::int32_t kNone = -8000;  // no reading: so far off that no plane goes through it and a reading

constexpr int kReach = 2, kSide = 2 * kReach + 1;
constexpr float kArea = kSide * kSide;
constexpr float kSlopeSquares = kArea * 2;  // sum of the squared places of a window along an axis
// Squares off the plane: those that noise alone gives 25 readings, of which the plane takes three, times 1.75, which is
// two and a half standard deviations more.
constexpr float kMostOff = 1.75f * 22 * 8 * 8;

constexpr int kStrip = 64, kWide = kStrip + 2 * kReach;
using Columns = std::array<std::int32_t, kWide>;

struct Row {
  Columns value{};
  bool any_far = false;  // there is a reading that may be smoothed
};

// Of each column the sums over the five rows around the middle.
struct Sums {
  Columns value{}, squares{}, slope{};
};

ONEMAP_TWIN_BODY void find_far_body(const float* z_m, bool& any) {
  int far = 0;
  for (std::size_t i = 0; i < kStrip; ++i) far |= static_cast<int>(z_m[i] >= kSmoothed_m);
  any = far != 0;
}

// What readings of `z_m` count as; none are 0.
ONEMAP_TWIN_BODY void count_row_body(const float* z_m, Columns& out) {
  for (std::size_t i = 0; i < kWide; ++i) {
    const float z = std::abs(z_m[i]);
    const float units = kUnitsPerInverseMetre / std::max(z, kAsked_m) + 0.5f;
    const bool asked = z >= kAsked_m && z <= kMaxDepth_m;
    out[i] = asked ? static_cast<std::int32_t>(units) - static_cast<std::int32_t>(kMiddle) : kNone;
  }
}

ONEMAP_TWIN_BODY void slide_body(const Columns& out, const Columns& in, Sums& sums) {
  for (std::size_t i = 0; i < kWide; ++i) {
    const std::int32_t gone = out[i], come = in[i];
    sums.slope[i] += (kReach + 1) * gone + kReach * come - sums.value[i];
    sums.value[i] += come - gone;
    sums.squares[i] += come * come - gone * gone;
  }
}

// z_m: the middle row.
ONEMAP_TWIN_BODY void fit_row_body(const Sums& sums, float* z_m) {
  const Columns &a = sums.value, &b = sums.squares, &c = sums.slope;
  for (std::size_t i = 0; i < kStrip; ++i) {
    const std::int32_t sum = a[i] + a[i + 1] + a[i + 2] + a[i + 3] + a[i + 4];
    const std::int32_t squares = b[i] + b[i + 1] + b[i + 2] + b[i + 3] + b[i + 4];
    const std::int32_t down = c[i] + c[i + 1] + c[i + 2] + c[i + 3] + c[i + 4];
    const std::int32_t across = 2 * (a[i + 4] - a[i]) + a[i + 3] - a[i + 1];
    const auto s = static_cast<float>(sum), u = static_cast<float>(across), v = static_cast<float>(down);
    const float off = static_cast<float>(squares) - s * s / kArea - (u * u + v * v) / kSlopeSquares;
    const float plane_m = kUnitsPerInverseMetre / (s / kArea + kMiddle), z = z_m[i];
    z_m[i] = ((off <= kMostOff) & (z >= kSmoothed_m)) ? plane_m : z;
  }
}

ONEMAP_TWIN(find_far, (const float* z_m, bool& any), (z_m, any))
ONEMAP_TWIN(count_row, (const float* z_m, Columns& out), (z_m, out))
ONEMAP_TWIN(slide, (const Columns& out, const Columns& in, Sums& sums), (out, in, sums))
ONEMAP_TWIN(fit_row, (const Sums& sums, float* z_m), (sums, z_m))

// A strip of the image, from top to bottom.
class Strip {
 public:
  Strip(float* first, int columns, int width, int height, bool simd)
      : first_(first), columns_(columns), width_(width), height_(height), simd_(simd) {}

  // left: the two columns beside it as they were.
  void smooth(std::span<const std::array<float, 2>> left) {
    int last_far = -kSide;  // the row
    for (int y = 0; y < height_ + kReach; ++y) {
      const bool idle = y - last_far > kReach;
      const bool far = y < height_ && any_far(y);
      if (far) last_far = y;
      if (idle && !far) continue;
      if (idle) begin(left, y);
      push(left, y, far);
      if (const int middle = y - kReach; middle >= 0 && at(middle).any_far) smooth_row(middle);
    }
  }

 private:
  float* pixels(int y) const { return first_ + static_cast<std::ptrdiff_t>(y) * width_; }
  Row& at(int y) { return rows_[static_cast<std::size_t>(y % kSide)]; }

  bool any_far(int y) const {
    const float* z_m = pixels(y);
    if (columns_ < kStrip) return std::any_of(z_m, z_m + columns_, [](float z) { return z >= kSmoothed_m; });
    bool any = false;
    (simd_ ? find_far_simd : find_far_plain)(z_m, any);
    return any;
  }

  // Nothing is known above the rows before this one, which no plane asks.
  void begin(std::span<const std::array<float, 2>> left, int y) {
    for (Row& row : rows_) row.value.fill(kNone);
    sums_.value.fill(kSide * kNone);
    sums_.squares.fill(kSide * kNone * kNone);
    sums_.slope.fill(0);
    for (int before = std::max(y - kReach, 0); before < y; ++before) push(left, before, false);
  }

  // Rows below the image have no readings.
  void push(std::span<const std::array<float, 2>> left, int y, bool far) {
    std::array<float, kWide> z_m{};
    if (y < height_) {
      const auto& beside = left[static_cast<std::size_t>(y)];
      std::copy(beside.begin(), beside.end(), z_m.begin());
      std::copy_n(pixels(y), columns_ + kReach, z_m.begin() + kReach);
    }
    Row& row = at(y);
    const Columns old = row.value;
    row.any_far = far;
    (simd_ ? count_row_simd : count_row_plain)(z_m.data(), row.value);
    (simd_ ? slide_simd : slide_plain)(old, row.value, sums_);
  }

  void smooth_row(int y) {
    const auto fit = simd_ ? fit_row_simd : fit_row_plain;
    if (columns_ == kStrip) return fit(sums_, pixels(y));
    std::array<float, kStrip> z_m{};
    std::copy_n(pixels(y), columns_, z_m.begin());
    fit(sums_, z_m.data());
    std::copy_n(z_m.begin(), columns_, pixels(y));
  }

  float* first_;
  int columns_, width_, height_;
  bool simd_;
  std::array<Row, kSide> rows_;
  Sums sums_;
};

}  // namespace

DepthSmoother::DepthSmoother(std::size_t rows) {
  left_.reserve(rows);
  right_.reserve(rows);
}

std::size_t DepthSmoother::bytes() const { return (left_.capacity() + right_.capacity()) * sizeof(Pair); }

void DepthSmoother::smooth(float* depth_m, int width, int height, bool simd) {
  const bool fast = simd && simd_available();
  const auto two_from = [&](int column, std::vector<Pair>& out) {
    const float* z_m = depth_m + column;
    out.resize(static_cast<std::size_t>(height));
    for (Pair& pair : out) pair = {z_m[0], z_m[1]}, z_m += width;
  };
  two_from(0, left_);
  for (int first = kReach; first < width - kReach; first += kStrip) {
    const int columns = std::min(kStrip, width - kReach - first);
    two_from(first + columns - kReach, right_);
    Strip(depth_m + first, columns, width, height, fast).smooth(left_);
    std::swap(left_, right_);
  }
}

}  // namespace onemap::mapping
