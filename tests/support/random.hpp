#pragma once
#include <cstdint>

#include "hal/base/splitmix.hpp"

namespace onemap::test {

// The product's generator with what tests ask for besides.
class Random : public SplitMix {
 public:
  using SplitMix::SplitMix;
  // Uniform in [from, to], both included.
  std::int64_t integer(std::int64_t from, std::int64_t to) {
    return from + static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(to - from + 1));
  }
  double uniform(double from, double to) { return from + (to - from) * unit(); }
  double normal(double sigma) {  // sum of twelve uniforms
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += unit();
    return sigma * sum;
  }
};

}  // namespace onemap::test
