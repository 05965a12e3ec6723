#include "local/tracking/motion_gate.hpp"

#include <gtest/gtest.h>

#include "support/poses.hpp"

namespace onemap::mapping {
namespace {

Pose moved(double x_m, double angle_deg) { return {test::rotation({0, 1, 0}, angle_deg * M_PI / 180), {x_m, 0, 0}}; }

TEST(MotionGate, EitherMotionGoesBeyondAndBothStayWithin) {
  const MotionGate gate(0.1, 8);
  EXPECT_TRUE(gate.within(moved(0.09, 7.9)));
  EXPECT_FALSE(gate.beyond(moved(0.09, 7.9)));
  for (const Pose& far : {moved(0.11, 0), moved(0, 8.1), moved(-0.11, -8.1)}) {
    EXPECT_TRUE(gate.beyond(far));
    EXPECT_FALSE(gate.within(far));
  }
}

TEST(MotionGate, NothingIsWithinAGateOfZero) {
  EXPECT_FALSE(MotionGate(0, 0).within(Pose{}));
  EXPECT_FALSE(MotionGate(0, 0).beyond(Pose{})) << "nor beyond it, when it did not move";
}

}  // namespace
}  // namespace onemap::mapping
