#include "link_motion.hpp"

#include <Eigen/Cholesky>

#include "se3.hpp"

namespace onemap::mapping {

double chi_square(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.llt().solve(error));
}

LinkMotion motion_of(const ChainFrames& frames, const GraphEdge& link, bool own) {
  LinkMotion out{.link = &link, .own = own};
  const Pose T_x_b = frames.T_chain_anchor[link.a] * link.T_a_b;
  out.T_a_x = frames.T_chain_anchor[link.a].inverse();
  out.T_x_y = T_x_b * frames.T_chain_anchor[link.b].inverse();
  const Matrix6d b_to_x = adjoint(T_x_b);
  out.covariance = b_to_x * link.information.llt().solve(Matrix6d::Identity()) * b_to_x.transpose();
  out.to_a = adjoint(out.T_a_x);
  out.y_to_x = adjoint(out.T_x_y);
  out.turn = out.covariance.topLeftCorner<3, 3>().trace();
  return out;
}

}  // namespace onemap::mapping
