#include "mapping/local/step.hpp"

#include <array>

namespace onemap::mapping {

std::string_view to_string(Step step) {
  constexpr std::array<std::string_view, kSteps> names{"gray",   "features", "cloud",  "match",    "fundamental",
                                                       "ransac", "icp",      "refine", "keyframe", "integrate"};
  return step < Step::count ? names[static_cast<std::size_t>(step)] : "count";
}

}  // namespace onemap::mapping
