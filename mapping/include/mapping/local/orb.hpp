#pragma once
#include <memory>

#include "mapping/image.hpp"
#include "mapping/local/features.hpp"

namespace onemap::mapping {

struct OrbConfig {
  int max_features = 500;
};

// OpenCV's ORB behind the same contract as Surf, as an alternative. OpenCV allocates while it detects.
class Orb {
 public:
  Orb(const OrbConfig& config, int width, int height);
  ~Orb();
  Orb(Orb&&) noexcept;
  Orb& operator=(Orb&&) noexcept;
  void detect(const GrayView& image, FeatureSet& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::mapping
