#pragma once
#include "chain_frame.hpp"

namespace onemap::mapping {

// What a link says of its two chains' frames, prepared for comparing it with many.
struct LinkMotion {
  const GraphEdge* link = nullptr;
  bool own = false;       // both ends on one chain
  Pose T_x_y{};           // chain y's frame (b is on it) in chain x's (a is on it)
  Pose T_a_x{};           // chain x in anchor a: errors are looked at there, without the lever arm of the chain's frame
  Matrix6d covariance{};  // of T_x_y by the link alone, in chain x's frame
  Matrix6d to_a{}, y_to_x{};  // adjoints of T_a_x and T_x_y
  double turn = 0;            // trace of the covariance's rotation part: is the same in every frame
};
LinkMotion motion_of(const ChainFrames& frames, const GraphEdge& link, bool own);

double chi_square(const Vector6d& error, const Matrix6d& covariance);

}  // namespace onemap::mapping
