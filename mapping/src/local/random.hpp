#pragma once
#include <array>
#include <cstdint>

namespace onemap::mapping {

// splitmix64: the same numbers on every machine for the same seed.
class SplitMix {
 public:
  explicit SplitMix(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  // 0 .. n - 1, n < 2^32.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(((next() >> 32) * n) >> 32); }

  // N different numbers below n (n >= N).
  template <std::size_t N>
  std::array<std::size_t, N> sample(std::size_t n) {
    std::array<std::size_t, N> out{};
    for (std::size_t i = 0; i < N;) {
      out[i] = below(n);
      bool fresh = true;
      for (std::size_t j = 0; j < i; ++j) fresh = fresh && out[j] != out[i];
      if (fresh) ++i;
    }
    return out;
  }

 private:
  std::uint64_t state_;
};

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
