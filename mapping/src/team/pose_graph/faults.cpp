#include "faults.hpp"

#include <Eigen/Cholesky>

namespace onemap::mapping {

namespace {

constexpr std::uint32_t kKeyframeEnd = 1u << 20;  // g2o's vertex ids keep twenty bits for it
constexpr double kFarthest_m = 21'000;            // what a pose in records can say
constexpr double kMostInformation = 1e14;         // sure to a tenth of a micrometre or microradian
constexpr double kMostVariance = 1e6;             // unsure by a kilometre
constexpr double kHalfMost_m = 1'000;             // a box is a submap's

bool is_rotation(const Matrix3d& R) {
  // Rounding of records (2^-30) and products of a few; anything else is a mistake of the caller's or of a stranger's.
  return R.allFinite() && (R * R.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
         R.determinant() > 0;
}

bool is_motion(const Pose& pose) {
  return is_rotation(pose.R) && pose.t.allFinite() && pose.t.cwiseAbs().maxCoeff() <= kFarthest_m;
}

bool is_information(const Matrix6d& m) {
  if (!m.allFinite() || (m - m.transpose()).cwiseAbs().maxCoeff() > 1e-9 * m.cwiseAbs().maxCoeff()) return false;
  const Eigen::LLT<Matrix6d> llt(m);
  if (llt.info() != Eigen::Success) return false;
  const Matrix6d covariance = llt.solve(Matrix6d::Identity());
  return m.diagonal().maxCoeff() <= kMostInformation && covariance.diagonal().minCoeff() > 0 &&
         covariance.diagonal().maxCoeff() <= kMostVariance;
}

std::string fault_of(const LinkEnd& end) {
  if (end.keyframe >= kKeyframeEnd) return "keyframe number of 2^20 or more";
  if (end.anchor > end.keyframe) return "keyframe " + std::to_string(end.keyframe) + " hangs on a later anchor";
  if (!is_motion(end.T_anchor_keyframe)) return "T_anchor_keyframe is not a motion";
  return {};
}

}  // namespace

std::string fault_of(const ChainAnchor& anchor) {
  if (anchor.keyframe >= kKeyframeEnd) return "keyframe number of 2^20 or more";
  if (!is_motion(anchor.T_previous_anchor)) return "T_previous_anchor is not a motion";
  if (!is_information(anchor.information))
    return "information is not symmetric and positive definite, with sigmas of 1e-7 to 1e3";
  if (!anchor.box_centre_m.allFinite() || !(anchor.box_half_m.array() >= 0).all() ||
      !(anchor.box_half_m.array() <= kHalfMost_m).all() || anchor.box_centre_m.cwiseAbs().maxCoeff() > kHalfMost_m)
    return "box is not a box of at most 1 km";
  return {};
}

std::string fault_of(const GraphLink& link) {
  if (!(link.a.keyframe_id() < link.b.keyframe_id())) return "a must be before b";
  if (link.a.anchor_id() == link.b.anchor_id()) return "both ends hang on one anchor";
  if (!is_motion(link.T_a_b)) return "T_a_b is not a motion";
  if (link.inliers == 0) return "no inliers";
  for (const LinkEnd& end : {link.a, link.b})
    if (std::string fault = fault_of(end); !fault.empty()) return fault;
  return {};
}

}  // namespace onemap::mapping
