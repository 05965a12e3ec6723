#pragma once
#include "mapping/team/pose_graph_input.hpp"

// Small motions D(d) = small_motion(d) at the right of a pose, in its own frame: X D(d). No lever arms in the
// equations.
namespace onemap::mapping {

// X D(d) = D(adjoint(X) d) X, to first order.
Matrix6d adjoint(const Pose& X);

// d with D(d) = E to first order, for every E: twice the vector part of the unit quaternion (2 sin(angle/2), so it
// never exceeds 2 and needs no arc function) and the translation.
Vector6d motion_error(const Pose& E);

// d motion_error(E D(d)) / dd at d = 0, exact.
Matrix6d motion_error_slope(const Pose& E);

}  // namespace onemap::mapping
