#include "fetch/ask_ledger.hpp"

#include <gtest/gtest.h>

namespace onemap::comms {
namespace {
using namespace std::chrono_literals;

const RecordId kVoxels{{RobotId::from_name("a"), 3, 1}, 0}, kPose{{RobotId::from_name("a"), 1, 1}, 0};
const Instant kAsked{10s};

std::vector<std::uint32_t> indices(const AskLedger::Fragments& fragments) {
  std::vector<std::uint32_t> all;
  for (const auto& fragment : fragments) all.push_back(fragment.index);
  return all;
}

AskLedger with(const RecordId& id, std::uint32_t fragments) {
  AskLedger ledger;
  for (std::uint32_t k = 0; k < fragments; ++k) ledger.add(kAsked, {id, k}, k + 1);
  return ledger;
}

TEST(AskLedger, ThreeLaterAnswersAndTheReorderWindowMakeALoss) {
  AskLedger ledger = with(kVoxels, 6);
  for (const std::uint32_t serial : {2u, 3u}) ledger.answered(kAsked, 3, serial);
  EXPECT_TRUE(ledger.take_overtaken(kAsked + 1s, 3, 5ms).empty()) << "two are not enough";
  ledger.answered(kAsked + 1ms, 3, 4);
  EXPECT_TRUE(ledger.take_overtaken(kAsked + 5ms, 3, 5ms).empty()) << "it may still be on its way";
  EXPECT_EQ(ledger.next_deadline({}), kAsked + 1ms + RoundTrip().reorder_window());
  EXPECT_EQ(indices(ledger.take_overtaken(kAsked + 6ms, 3, 5ms)), std::vector<std::uint32_t>{0});
  EXPECT_EQ(ledger.outstanding(), 2u);
  EXPECT_TRUE(ledger.take_overtaken(kAsked + 9s, 3, 5ms).empty()) << "once";
}

TEST(AskLedger, SilenceLosesAllOfALaneAndIsCounted) {
  AskLedger ledger = with(kVoxels, 3);
  const RoundTrip trip;
  ledger.add(kAsked, {kPose, 0}, 9);
  EXPECT_TRUE(ledger.take_silent(kAsked + 99ms, 3, trip).empty());
  ledger.progressed(kAsked + 50ms, 1);
  EXPECT_TRUE(ledger.take_silent(kAsked + 149ms, 3, trip).empty()) << "a lower lane moved: the peer is busy with it";
  EXPECT_EQ(indices(ledger.take_silent(kAsked + 150ms, 3, trip)), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(ledger.silences(), 1u);
  EXPECT_EQ(ledger.outstanding(), 1u);
  ledger.progressed(kAsked + 200ms, 1);
  EXPECT_EQ(ledger.silences(), 0u);
}

TEST(AskLedger, WhatIsWithdrawnIsNeitherOutstandingNorLost) {
  AskLedger ledger = with(kVoxels, 5);
  ledger.withdraw(kVoxels, 3);
  EXPECT_EQ(ledger.outstanding(), 3u);
  ledger.withdraw(kPose);
  EXPECT_EQ(ledger.outstanding(), 3u);
  ledger.withdraw(kVoxels);
  EXPECT_EQ(ledger.outstanding(), 0u);
  EXPECT_TRUE(ledger.take_silent(kAsked + 10s, 3, {}).empty());
  EXPECT_EQ(ledger.next_deadline({}), Instant::max());
}

TEST(AskLedger, WhoIsThereIsNotWaitedForLong) {
  AskLedger ledger;
  RoundTrip trip;
  for (int k = 0; k < 12; ++k) {
    ledger.add(kAsked, {kVoxels, 0}, 1);
    ledger.take_silent(kAsked + 10s, 3, trip);
  }
  EXPECT_EQ(ledger.silences(), 12u);
  ledger.is_there();
  EXPECT_EQ(ledger.silences(), RoundTrip::kPatientSilences);
  EXPECT_FALSE(ledger.avoided(kAsked));
  ledger.avoid(kAsked);
  EXPECT_TRUE(ledger.avoided(kAsked + 999ms));
  EXPECT_FALSE(ledger.avoided(kAsked + 1s));
}

}  // namespace
}  // namespace onemap::comms
