#include "graph_edge.hpp"

#include <algorithm>
#include <cmath>

#include "se3.hpp"

namespace onemap::mapping {

GraphEdge edge_of(const GraphLink& link, const LinkNoise& noise) {
  const double share = std::max(noise.least_share, std::sqrt(noise.inliers / std::max(1u, link.inliers)));
  const Matrix6d of_keyframes = information_of(noise.rotation_rad * share, noise.translation_m * share);
  const Pose T_keyframe_anchor_b = link.b.T_anchor_keyframe.inverse();
  // An error d of anchor b's frame is one of adjoint(T_keyframe_anchor) d of the keyframe's.
  const Matrix6d lever = adjoint(T_keyframe_anchor_b);
  return {0, 0, link.a.T_anchor_keyframe * link.T_a_b * T_keyframe_anchor_b, lever.transpose() * of_keyframes * lever};
}

Linearised linearise(const GraphEdge& edge, const Pose& X_a, const Pose& X_b) {
  const Pose T_b_a = X_b.inverse() * X_a;
  const Pose E = edge.T_a_b.inverse() * T_b_a.inverse();
  Linearised out;
  out.error = motion_error(E);
  out.J_b = motion_error_slope(E);
  out.J_a = -out.J_b * adjoint(T_b_a);
  return out;
}

double squared_error(const GraphEdge& edge, const Pose& X_a, const Pose& X_b) {
  const Vector6d e = motion_error(edge.T_a_b.inverse() * (X_a.inverse() * X_b));
  return e.dot(edge.information * e);
}

}  // namespace onemap::mapping
