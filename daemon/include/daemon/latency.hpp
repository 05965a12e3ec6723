#pragma once
#include <array>
#include <cstdint>

#include "hal/base/time.hpp"

namespace onemap::daemon {

struct Quantiles {
  double p50_ms = 0, p95_ms = 0, p99_ms = 0;
};

// Durations in fixed memory: buckets of 0.05 ms up to 500 ms, longer ones in the last. Quantiles are upper bucket
// edges, so they are at most 0.05 ms too large.
class LatencyHistogram {
 public:
  void add(Duration duration);
  std::uint64_t count() const { return count_; }
  double total_ms() const { return total_ms_; }
  double quantile_ms(double q) const;  // 0 when nothing was added
  Quantiles quantiles() const { return {quantile_ms(0.50), quantile_ms(0.95), quantile_ms(0.99)}; }

 private:
  static constexpr double kBucket_ms = 0.05;
  static constexpr std::size_t kBuckets = 10000;
  std::array<std::uint32_t, kBuckets + 1> buckets_{};
  std::uint64_t count_ = 0;
  double total_ms_ = 0;
};

}  // namespace onemap::daemon
