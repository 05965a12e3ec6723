#include "mapping/local/step.hpp"

namespace onemap::mapping {

std::string_view to_string(Step step) {
  switch (step) {
    case Step::gray:
      return "gray";
    case Step::features:
      return "features";
    case Step::cloud:
      return "cloud";
    case Step::match:
      return "match";
    case Step::fundamental:
      return "fundamental";
    case Step::ransac:
      return "ransac";
    case Step::icp:
      return "icp";
    case Step::refine:
      return "refine";
    case Step::keyframe:
      return "keyframe";
    case Step::integrate:
      return "integrate";
    case Step::count:
      return "count";
  }
  return "unknown";
}

}  // namespace onemap::mapping
