#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/image.hpp"
#include "mapping/local/features.hpp"

// The parts of SURF (Bay, Tuytelaars, Van Gool 2006) behind Surf::detect, each with a plain version and, where `simd`
// is true and the CPU has it, a version compiled for AVX2 from the same source: integers, and floats in the same order,
// so both give the same bits.
namespace onemap::mapping::surf {

bool cpu_has_avx2();

// Sums of all pixels above and left: at(x, y) = sum of image[0..y)[0..x). (width + 1) x (height + 1), modulo 2^32.
struct IntegralImage {
  int width = 0, height = 0;  // of the image
  int stride = 0;             // elements a row
  std::vector<std::uint32_t> sums;

  void resize(int image_width, int image_height);
  void build(const GrayView& image);
  const std::uint32_t* row(int y) const { return sums.data() + static_cast<std::ptrdiff_t>(y) * stride; }
};

// Determinant of the Hessian by box filters of one size at every step-th pixel; 0 where the filter does not fit.
struct ResponseLayer {
  int filter = 9, step = 1;  // filter: side in pixels, an odd multiple of 3
  int width = 0, height = 0;
  std::vector<float> values;  // width x height
  const float* row(int y) const { return values.data() + static_cast<std::ptrdiff_t>(y) * width; }
  float* row(int y) { return values.data() + static_cast<std::ptrdiff_t>(y) * width; }
};

// Rows that fill_layer works in, each image width + 1.
struct RowScratch {
  std::vector<std::int32_t> xx, yy, xy;
};

void fill_layer(const IntegralImage& integral, ResponseLayer& layer, RowScratch& scratch, bool simd);
// The same filter at twice the step.
void subsample_layer(const ResponseLayer& finer, ResponseLayer& layer);

// Sign of the trace of the Hessian at a pixel where the filter fits.
std::int8_t laplacian_sign(const IntegralImage& integral, int x, int y, int filter);

struct Candidate {
  float x_px, y_px, scale;  // scale: the paper's s = 1.2 / 9 * filter
  float response;
  std::int8_t laplacian;
};
// Strongest first; position and scale break ties, so the order is total.
bool stronger(const Candidate& a, const Candidate& b);

// Local maxima above the threshold among the 26 neighbours in (x, y, filter size), moved to the vertex of the quadratic
// through them. Appended to `out`, whose capacity is kept: when full, the weaker half goes.
void find_maxima(const IntegralImage& integral, std::span<const ResponseLayer, 3> layers, float threshold,
                 std::span<std::uint8_t> row_mask, bool simd, std::vector<Candidate>& out);

// Chooses at most max_count of the candidates: the strongest, but some from each cell of a grid and not too many from
// any. `candidates` is left with the chosen ones, strongest first.
struct Spread {
  std::vector<std::uint16_t> taken;      // by cell
  std::vector<Candidate> chosen, spare;  // working space, as large as the candidates'
  void reserve(int width, int height, std::size_t max_candidates);
  void select(std::size_t max_count, std::vector<Candidate>& candidates);

 private:
  void take(std::size_t share, std::size_t max_count, const std::vector<Candidate>& candidates);
  int cells_x_ = 0;
};

// The direction of the strongest sector of Haar wavelet responses within 6 s, as a unit vector.
struct Direction {
  float cos, sin;
};
Direction dominant_direction(const IntegralImage& integral, float x_px, float y_px, float scale, bool simd);

// 4 x 4 cells of (sum dx, sum |dx|, sum dy, sum |dy|) over a window of 24 s turned to `direction`.
void describe(const IntegralImage& integral, float x_px, float y_px, float scale, Direction direction, bool simd,
              Descriptor& out);

}  // namespace onemap::mapping::surf
