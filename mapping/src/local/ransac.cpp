#include "mapping/local/ransac.hpp"

namespace onemap::mapping {

std::string_view to_string(RansacReason reason) {
  switch (reason) {
    case RansacReason::ok:
      return "ok";
    case RansacReason::too_few_matches:
      return "too_few_matches";
    case RansacReason::degenerate:
      return "degenerate";
    case RansacReason::too_few_inliers:
      return "too_few_inliers";
  }
  return "unknown";
}

}  // namespace onemap::mapping
