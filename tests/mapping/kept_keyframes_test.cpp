#include "mapping/team/kept_keyframes.hpp"

#include <gtest/gtest.h>

#include "support/simulated_keyframes.hpp"

namespace onemap::mapping {
namespace {

KeyframeRecord record_of(const test::SimulatedKeyframes& keyframes, std::uint32_t index) {
  KeyframeRecord record;
  record.index = record.anchor = index;
  const std::size_t i = index % keyframes.grids.size();
  record.grid = keyframes.grids[i];
  record.T_robot_keyframe = quantize(keyframes.poses[i]);
  record.features.resize(400);
  return record;
}

TEST(KeptKeyframes, KeepTheGridAndThePoseInFewBytes) {
  const auto keyframes = test::simulated_keyframes("simulated:office?frames=20&width=320&height=240", 5);
  KeptKeyframes kept(1 << 20);
  for (std::uint32_t i = 0; i < 4; ++i) kept.add(record_of(keyframes, i));
  ASSERT_EQ(kept.all().size(), 4u);
  EXPECT_EQ(kept.left_out(), 0u);
  EXPECT_LT(kept.bytes(), 4 * 12'000u);
  const auto back = decode_keyframe(kept.all()[2].body);
  ASSERT_TRUE(back.ok()) << back.error().text();
  EXPECT_EQ(back->index, 2u);
  EXPECT_EQ(back->T_robot_keyframe, kept.all()[2].T_robot_keyframe);
  EXPECT_EQ(back->grid.inverse_depth, keyframes.grids[2].inverse_depth);
  EXPECT_TRUE(back->features.empty());
}

TEST(KeptKeyframes, AFullBudgetThinsOutTheWholeWay) {
  const auto keyframes = test::simulated_keyframes("simulated:office?frames=20&width=320&height=240", 5);
  KeptKeyframes kept(200'000);
  for (std::uint32_t i = 0; i < 300; ++i) {
    kept.add(record_of(keyframes, i));
    ASSERT_LE(kept.bytes(), 200'000u);
  }
  EXPECT_GT(kept.all().size(), 10u);
  EXPECT_EQ(kept.left_out() + kept.all().size(), 300u);
  const std::uint32_t step = kept.all()[1].index - kept.all()[0].index;
  EXPECT_EQ(kept.all().front().index, 0u);
  for (std::size_t i = 1; i < kept.all().size(); ++i)
    EXPECT_EQ(kept.all()[i].index - kept.all()[i - 1].index, step) << "evenly";
  EXPECT_GT(kept.all().back().index, 300 - 2 * step);
}

}  // namespace
}  // namespace onemap::mapping
