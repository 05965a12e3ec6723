#include <algorithm>
#include <cstring>

#include "surf_internal.hpp"
#include "twin.hpp"

namespace onemap::mapping::surf {

bool cpu_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

void IntegralImage::resize(int image_width, int image_height) {
  width = image_width;
  height = image_height;
  stride = image_width + 1;
  sums.assign(static_cast<std::size_t>(stride) * (static_cast<std::size_t>(image_height) + 1), 0);
}

void IntegralImage::build(const GrayView& image) {
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = image.row(y);
    const std::uint32_t* above = row(y) + 1;
    std::uint32_t* out = sums.data() + static_cast<std::ptrdiff_t>(y + 1) * stride + 1;
    std::uint32_t sum = 0;
    for (int x = 0; x < width; ++x) {
      sum += in[x];
      out[x] = sum + above[x];
    }
  }
}

namespace {

// Box filters of side `filter` (lobe = filter / 3) about pixel (x, y), after the paper's figure 2. Each is a difference
// of sums of columns, so the sums of a row of columns are made once: Dxx = xx[x3] - xx[x0] - 3 (xx[x2] - xx[x1]).
struct ColumnSums {
  const std::uint32_t *xx0, *xx1;              // rows of the lobes of Dxx
  const std::uint32_t *yy0, *yy1, *yy2, *yy3;  // of Dyy: outer, inner, inner, outer
  const std::uint32_t *xy0, *xy1, *xy2, *xy3;  // of Dxy: upper pair, lower pair
};

ColumnSums column_sums(const IntegralImage& integral, int y, int filter) {
  const int lobe = filter / 3, half = filter / 2, inner = lobe / 2;
  return {integral.row(y - lobe + 1),  integral.row(y + lobe),     integral.row(y - half), integral.row(y - inner),
          integral.row(y + inner + 1), integral.row(y + half + 1), integral.row(y - lobe), integral.row(y),
          integral.row(y + 1),         integral.row(y + lobe + 1)};
}

ONEMAP_TWIN_BODY void sum_columns_body(const ColumnSums& in, int count, std::int32_t* __restrict xx,
                                       std::int32_t* __restrict yy, std::int32_t* __restrict xy) {
  for (int x = 0; x < count; ++x) {
    xx[x] = static_cast<std::int32_t>(in.xx1[x] - in.xx0[x]);
    yy[x] = static_cast<std::int32_t>(in.yy3[x] - in.yy0[x] - 3 * (in.yy2[x] - in.yy1[x]));
    xy[x] = static_cast<std::int32_t>((in.xy1[x] - in.xy0[x]) - (in.xy3[x] - in.xy2[x]));
  }
}

struct RowFilter {
  const std::int32_t *xx, *yy, *xy;
  int filter, first, count;  // results first .. first + count - 1
};

// det(H) = Dxx Dyy - (0.9 Dxy)^2, normalised by the filter's area.
template <int kStep>
ONEMAP_TWIN_BODY void determinant_body(const RowFilter& in, float* __restrict out) {
  const int lobe = in.filter / 3, half = in.filter / 2, inner = lobe / 2;
  const float norm = 1.f / static_cast<float>(in.filter * in.filter);
  const std::int32_t *xx = in.xx + in.first * kStep, *yy = in.yy + in.first * kStep, *xy = in.xy + in.first * kStep;
  for (int i = 0; i < in.count; ++i) {
    const int x = i * kStep;
    const std::int32_t dxx = xx[x + half + 1] - xx[x - half] - 3 * (xx[x + inner + 1] - xx[x - inner]);
    const std::int32_t dyy = yy[x + lobe] - yy[x - lobe + 1];
    const std::int32_t dxy = (xy[x + lobe + 1] - xy[x + 1]) - (xy[x] - xy[x - lobe]);
    const float a = static_cast<float>(dxx) * norm, b = static_cast<float>(dyy) * norm;
    const float c = static_cast<float>(dxy) * norm;
    out[in.first + i] = a * b - 0.81f * (c * c);
  }
}

ONEMAP_TWIN_BODY void fill_row_body(const ColumnSums& sums, int width, const RowFilter& row, int step,
                                    RowScratch& scratch, float* out) {
  sum_columns_body(sums, width + 1, scratch.xx.data(), scratch.yy.data(), scratch.xy.data());
  switch (step) {
    case 1:
      determinant_body<1>(row, out);
      break;
    case 2:
      determinant_body<2>(row, out);
      break;
    case 4:
      determinant_body<4>(row, out);
      break;
    default:
      determinant_body<8>(row, out);
      break;
  }
}

ONEMAP_TWIN(fill_row,
            (const ColumnSums& sums, int width, const RowFilter& row, int step, RowScratch& scratch, float* out),
            (sums, width, row, step, scratch, out))

}  // namespace

void fill_layer(const IntegralImage& integral, ResponseLayer& layer, RowScratch& scratch, bool simd) {
  const int half = layer.filter / 2, step = layer.step;
  const int first = (half + step - 1) / step;
  const int last_x = (integral.width - 1 - half) / step, last_y = (integral.height - 1 - half) / step;
  if (integral.width <= 2 * half || integral.height <= 2 * half || last_x < first) return;
  const RowFilter row{scratch.xx.data(), scratch.yy.data(), scratch.xy.data(), layer.filter, first, last_x - first + 1};
  const auto fill = simd ? fill_row_simd : fill_row_plain;
  for (int y = first; y <= last_y; ++y)
    fill(column_sums(integral, y * step, layer.filter), integral.width, row, step, scratch, layer.row(y));
}

void subsample_layer(const ResponseLayer& finer, ResponseLayer& layer) {
  for (int y = 0; y < layer.height; ++y) {
    const float* in = finer.row(2 * y);
    float* out = layer.row(y);
    for (int x = 0; x < layer.width; ++x) out[x] = in[2 * x];
  }
}

std::int8_t laplacian_sign(const IntegralImage& integral, int x, int y, int filter) {
  const int lobe = filter / 3, half = filter / 2, inner = lobe / 2;
  const auto box = [&](int x0, int y0, int x1, int y1) {
    return static_cast<std::int32_t>(integral.row(y1)[x1] - integral.row(y1)[x0] - integral.row(y0)[x1] +
                                     integral.row(y0)[x0]);
  };
  const std::int32_t dxx =
      box(x - half, y - lobe + 1, x + half + 1, y + lobe) - 3 * box(x - inner, y - lobe + 1, x + inner + 1, y + lobe);
  const std::int32_t dyy =
      box(x - lobe + 1, y - half, x + lobe, y + half + 1) - 3 * box(x - lobe + 1, y - inner, x + lobe, y + inner + 1);
  return dxx + dyy < 0 ? -1 : 1;
}

}  // namespace onemap::mapping::surf
