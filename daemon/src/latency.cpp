#include "daemon/latency.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::daemon {

void LatencyHistogram::add(Duration duration) {
  const double ms = std::max(0.0, to_seconds(duration) * 1e3);
  const double bucket = std::min(ms / kBucket_ms, static_cast<double>(kBuckets));
  ++buckets_[static_cast<std::size_t>(bucket)];
  ++count_;
  total_ms_ += ms;
}

double LatencyHistogram::quantile_ms(double q) const {
  if (count_ == 0) return 0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    seen += buckets_[i];
    if (seen >= std::max<std::uint64_t>(1, wanted)) return kBucket_ms * static_cast<double>(i + 1);
  }
  return kBucket_ms * static_cast<double>(kBuckets);
}

}  // namespace onemap::daemon
