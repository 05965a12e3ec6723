#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "surf_internal.hpp"
#include "twin.hpp"

namespace onemap::mapping::surf {

bool stronger(const Candidate& a, const Candidate& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.y_px != b.y_px) return a.y_px < b.y_px;
  if (a.x_px != b.x_px) return a.x_px < b.x_px;
  return a.scale < b.scale;
}

namespace {

// 1 where a value is above the threshold and its four neighbours in the row and column; ties go to the first.
ONEMAP_TWIN_BODY void mark_row_body(const float* above, const float* row, const float* below, int count,
                                    float threshold, std::uint8_t* __restrict mask) {
  for (int x = 0; x < count; ++x) {
    const float v = row[x];
    mask[x] = static_cast<std::uint8_t>((v > threshold) & (v > row[x - 1]) & (v >= row[x + 1]) & (v > above[x]) &
                                        (v >= below[x]));
  }
}
ONEMAP_TWIN(mark_row,
            (const float* above, const float* row, const float* below, int count, float threshold, std::uint8_t* mask),
            (above, row, below, count, threshold, mask))

using Neighbourhood = float[3][3][3];  // [layer][y][x]

void read(std::span<const ResponseLayer, 3> layers, int x, int y, Neighbourhood& n) {
  for (int l = 0; l < 3; ++l)
    for (int dy = 0; dy < 3; ++dy)
      std::memcpy(n[l][dy], layers[static_cast<std::size_t>(l)].row(y + dy - 1) + x - 1, 3 * sizeof(float));
}

bool is_maximum(const Neighbourhood& n) {
  const float* flat = &n[0][0][0];
  const float v = flat[13];
  for (int i = 0; i < 13; ++i)
    if (flat[i] >= v) return false;
  for (int i = 14; i < 27; ++i)
    if (flat[i] > v) return false;
  return true;
}

// Vertex of the quadratic through the neighbourhood, in steps from its centre: H offset = -gradient (Brown and Lowe),
// by Cramer's rule. False when it is not a maximum nearby.
bool vertex(const Neighbourhood& n, float (&offset)[3]) {
  const float v2 = 2 * n[1][1][1];
  const float gx = 0.5f * (n[1][1][2] - n[1][1][0]), gy = 0.5f * (n[1][2][1] - n[1][0][1]);
  const float gs = 0.5f * (n[2][1][1] - n[0][1][1]);
  const float xx = n[1][1][2] + n[1][1][0] - v2, yy = n[1][2][1] + n[1][0][1] - v2, ss = n[2][1][1] + n[0][1][1] - v2;
  const float xy = 0.25f * (n[1][2][2] + n[1][0][0] - n[1][2][0] - n[1][0][2]);
  const float xs = 0.25f * (n[2][1][2] + n[0][1][0] - n[2][1][0] - n[0][1][2]);
  const float ys = 0.25f * (n[2][2][1] + n[0][0][1] - n[2][0][1] - n[0][2][1]);
  const float a = yy * ss - ys * ys, b = xs * ys - xy * ss, c = xy * ys - yy * xs;
  const float det = xx * a + xy * b + xs * c;
  if (det == 0) return false;
  offset[0] = -(a * gx + b * gy + c * gs) / det;
  offset[1] = -(b * gx + (xx * ss - xs * xs) * gy + (xs * xy - xx * ys) * gs) / det;
  offset[2] = -(c * gx + (xs * xy - xx * ys) * gy + (xx * yy - xy * xy) * gs) / det;
  for (const float o : offset)
    if (!(o > -1.f && o < 1.f)) return false;
  return true;
}

// Keeps the stronger half, so that detection can go on in the memory that there is.
void make_room(std::vector<Candidate>& out) {
  const auto middle = out.begin() + static_cast<std::ptrdiff_t>(out.size() / 2);
  std::nth_element(out.begin(), middle, out.end(), stronger);
  out.erase(middle, out.end());
}

void examine(const IntegralImage& integral, std::span<const ResponseLayer, 3> layers, int x, int y,
             std::vector<Candidate>& out) {
  Neighbourhood n;
  read(layers, x, y, n);
  float offset[3];
  if (!is_maximum(n) || !vertex(n, offset)) return;
  const ResponseLayer& layer = layers[1];
  const float step = static_cast<float>(layer.step);
  const float filter =
      static_cast<float>(layer.filter) + offset[2] * static_cast<float>(layers[2].filter - layer.filter);
  if (out.size() == out.capacity()) make_room(out);
  out.push_back({(static_cast<float>(x) + offset[0]) * step, (static_cast<float>(y) + offset[1]) * step,
                 filter * (1.2f / 9.f), n[1][1][1],
                 laplacian_sign(integral, x * layer.step, y * layer.step, layer.filter)});
}

}  // namespace

void find_maxima(const IntegralImage& integral, std::span<const ResponseLayer, 3> layers, float threshold,
                 std::span<std::uint8_t> row_mask, bool simd, std::vector<Candidate>& out) {
  const ResponseLayer& layer = layers[1];
  // The largest of the three filters must fit, and one more step for the neighbours.
  const int first = (layers[2].filter / 2 + layer.step - 1) / layer.step + 1;
  const int end_x = (integral.width - 1 - layers[2].filter / 2) / layer.step;
  const int end_y = (integral.height - 1 - layers[2].filter / 2) / layer.step;
  const auto mark = simd ? mark_row_simd : mark_row_plain;
  const int count = end_x - first;
  if (count <= 0) return;
  std::uint8_t* mask = row_mask.data();  // at least 8 longer than a row
  std::memset(mask + count, 0, 8);
  for (int y = first; y < end_y; ++y) {
    mark(layer.row(y - 1) + first, layer.row(y) + first, layer.row(y + 1) + first, count, threshold, mask);
    for (int x = 0; x < count; x += 8) {
      std::uint64_t marks = 0;
      std::memcpy(&marks, mask + x, 8);
      if (marks == 0) continue;
      for (int i = x; i < x + 8; ++i)
        if (mask[i] != 0) examine(integral, layers, first + i, y, out);
    }
  }
}

}  // namespace onemap::mapping::surf
