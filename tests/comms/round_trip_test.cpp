#include "peer/round_trip.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

TEST(RoundTrip, SmoothsWhatItMeasures) {
  RoundTrip trip;
  EXPECT_EQ(trip.smoothed(), 0ns);
  EXPECT_EQ(trip.give_up_after(0), 100ms) << "before it is measured";
  for (int k = 0; k < 40; ++k) trip.sample(20ms);
  EXPECT_NEAR(to_seconds(trip.smoothed()), 0.020, 0.0005);
  EXPECT_GE(trip.give_up_after(0), 30ms);
  EXPECT_LT(trip.give_up_after(0), 50ms);
  trip.sample(200ms);
  EXPECT_GT(trip.give_up_after(0), 100ms) << "one late answer makes it patient";
}

// The first answer of all, or a later one, of somebody who was stopped while the question waited.
TEST(RoundTrip, OneVeryLateAnswerIsNotBelievedAndALongWayIs) {
  RoundTrip first, later, far;
  first.sample(1500ms);
  EXPECT_LE(first.give_up_after(0), 600ms);
  for (int k = 0; k < 40; ++k) later.sample(20ms);
  later.sample(1500ms);
  EXPECT_LE(later.give_up_after(0), 300ms);
  for (int k = 0; k < 6; ++k) far.sample(900ms);
  EXPECT_GT(far.give_up_after(0), 900ms);
  for (int k = 0; k < 40; ++k) far.sample(900ms);
  EXPECT_NEAR(to_seconds(far.smoothed()), 0.9, 0.05);
}

TEST(RoundTrip, PatienceGrowsSlowlyAndEnds) {
  RoundTrip trip;
  trip.sample(20ms);
  EXPECT_EQ(trip.give_up_after(RoundTrip::kPatientSilences), trip.give_up_after(0));
  EXPECT_EQ(trip.give_up_after(RoundTrip::kPatientSilences + 1), 2 * trip.give_up_after(0));
  EXPECT_EQ(trip.give_up_after(1000), 2000ms);
}

TEST(RoundTrip, HasteWidensTheReorderWindowAndIsForgotten) {
  RoundTrip trip;
  for (int k = 0; k < 40; ++k) trip.sample(20ms);
  const Duration calm = trip.reorder_window();
  for (int k = 0; k < 10; ++k) trip.was_hasty();
  EXPECT_EQ(trip.reorder_window(), calm + 10ms);
  for (int k = 0; k < 400; ++k) trip.sample(20ms);
  EXPECT_LT(trip.reorder_window(), calm + 1ms);
  for (int k = 0; k < 1000; ++k) trip.was_hasty();
  EXPECT_LE(trip.reorder_window(), calm + 201ms);
}

}  // namespace
}  // namespace onemap::comms
