#include "mapping/local/track_reason.hpp"

#include <array>

namespace onemap::mapping {

std::string_view to_string(TrackReason reason) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(TrackReason::count)> names{
      "ok",
      "first frame",
      "too few features",
      "too few matches",
      "fundamental matrix failed",
      "too few coherent depths",
      "3D RANSAC failed",
      "ICP failed",
      "inconsistent motion",
      "time not increasing"};
  return reason < TrackReason::count ? names[static_cast<std::size_t>(reason)] : "count";
}

}  // namespace onemap::mapping
