#include "keep.hpp"

namespace onemap::mapping {

bool box_moved(const ChainAnchor& anchor, const Pose& in_use, const Pose& now, double bound_m) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vector3d p = anchor.box_centre_m + sign.cwiseProduct(anchor.box_half_m);
    if ((in_use * p - now * p).squaredNorm() >= bound_m * bound_m) return true;
  }
  return false;
}

}  // namespace onemap::mapping
