#pragma once
#include <memory>

#include "mapping/image.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

struct SurfConfig {
  int max_features = 500;          // the strongest are kept, spread over the image
  float hessian_threshold = 10.f;  // on the normalised determinant of the Hessian of an 8-bit image
  int octaves = 3;                 // each with 4 box-filter sizes
  bool upright = false;            // U-SURF: no dominant orientation (faster; no in-plane rotation)
  bool simd = true;                // false: the plain reference, which gives the same bits
};

// SURF (Bay, Tuytelaars, Van Gool 2006): determinant-of-Hessian blobs on an integral image, Haar-wavelet orientation
// and a 64-component descriptor. All memory is taken in the constructor; detect() does not allocate. Deterministic.
class Surf {
 public:
  Surf(const SurfConfig& config, int width, int height);
  ~Surf();
  Surf(Surf&&) noexcept;
  Surf& operator=(Surf&&) noexcept;
  // image: width x height as constructed. out is cleared; its capacity must be at least max_features.
  void detect(const GrayView& image, FeatureSet& out);
  std::size_t bytes() const;  // memory taken

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::mapping
