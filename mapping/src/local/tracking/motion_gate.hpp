#pragma once
#include <cmath>

#include "mapping/geometry.hpp"

namespace onemap::mapping {

// How far a camera may move, as a translation and a rotation.
class MotionGate {
 public:
  MotionGate(double translation_m, double rotation_deg)
      : squared_m2_(translation_m * translation_m), cosine_(std::cos(rotation_deg * 0.017453292519943295)) {}
  // More than one of the two.
  bool beyond(const Pose& moved) const {
    return moved.t.squaredNorm() > squared_m2_ || rotation_cosine(moved.R) < cosine_;
  }
  // Less than both.
  bool within(const Pose& moved) const {
    return moved.t.squaredNorm() < squared_m2_ && rotation_cosine(moved.R) > cosine_;
  }

 private:
  double squared_m2_, cosine_;
};

}  // namespace onemap::mapping
