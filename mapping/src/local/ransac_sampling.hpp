#pragma once
#include <array>
#include <cstdint>

#include "hal/base/splitmix.hpp"

namespace onemap::mapping {

// N different numbers below n (n >= N).
template <std::size_t N>
std::array<std::size_t, N> sample(SplitMix& random, std::size_t n) {
  std::array<std::size_t, N> out{};
  for (std::size_t i = 0; i < N;) {
    out[i] = random.below(n);
    bool fresh = true;
    for (std::size_t j = 0; j < i; ++j) fresh = fresh && out[j] != out[i];
    if (fresh) ++i;
  }
  return out;
}

// How many samples of `size` must be drawn until one without outliers was among them with the given confidence,
// at most `limit`. By products, not logarithms.
inline int ransac_iterations(double inlier_share, int size, double confidence, int limit) {
  double good = 1;
  for (int i = 0; i < size; ++i) good *= inlier_share;
  double none_good = 1;
  int n = 0;
  while (n < limit && none_good > 1 - confidence) {
    none_good *= 1 - good;
    ++n;
  }
  return n;
}

}  // namespace onemap::mapping
