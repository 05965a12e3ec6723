#pragma once
#include <cstdint>

namespace onemap::mapping {

// How a robust estimate ended; the estimators are in fundamental.hpp and rigid.hpp.
enum class RansacReason : std::uint8_t { ok, too_few_matches, degenerate, too_few_inliers };

struct RansacResult {
  RansacReason reason = RansacReason::too_few_matches;
  int iterations = 0;
  int inliers = 0;
  bool ok() const { return reason == RansacReason::ok; }
};

}  // namespace onemap::mapping
