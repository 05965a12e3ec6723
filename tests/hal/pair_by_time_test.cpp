#include "hal/imaging/pair_by_time.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

using namespace std::chrono_literals;

PairByTime::Image at_ms(int ms, std::uint32_t buffer = 0) { return {FrameTime(std::chrono::milliseconds(ms)), buffer}; }
int ms(const PairByTime::Image& image) { return static_cast<int>(image.time.time_since_epoch() / 1ms); }

// "c10" adds a colour image at 10 ms, "d10" a depth image; what is settled after each comes out as text.
std::string run(PairByTime& pairs, std::initializer_list<const char*> images) {
  std::string out;
  for (const char* image : images) {
    const int time = std::stoi(image + 1);
    const bool taken = image[0] == 'c' ? pairs.add_colour(at_ms(time)) : pairs.add_depth(at_ms(time));
    if (!taken) out += "refused ";
    while (true) {
      const PairByTime::Outcome o = pairs.next();
      if (o.kind == PairByTime::Kind::nothing) break;
      if (o.kind == PairByTime::Kind::pair) out += fmt::format("{}+{} ", ms(o.colour), ms(o.depth));
      if (o.kind == PairByTime::Kind::lone_colour) out += fmt::format("c{} ", ms(o.colour));
      if (o.kind == PairByTime::Kind::lone_depth) out += fmt::format("d{} ", ms(o.depth));
    }
  }
  return out;
}

TEST(PairByTime, PairsAsSoonAsBothAreThere) {
  PairByTime pairs(15ms, 4);
  EXPECT_EQ(run(pairs, {"c0", "d5", "d38", "c33", "c66", "d70"}), "0+5 33+38 66+70 ");
  EXPECT_EQ(pairs.unmatched(), 0u);
}

TEST(PairByTime, TellsBuffersApart) {
  PairByTime pairs(15ms, 4);
  ASSERT_TRUE(pairs.add_colour(at_ms(1, 7)));
  ASSERT_EQ(pairs.next().kind, PairByTime::Kind::nothing);
  ASSERT_TRUE(pairs.add_depth(at_ms(2, 9)));
  const PairByTime::Outcome pair = pairs.next();
  EXPECT_EQ(pair.kind, PairByTime::Kind::pair);
  EXPECT_EQ(pair.colour, at_ms(1, 7));
  EXPECT_EQ(pair.depth, at_ms(2, 9));
}

TEST(PairByTime, WhatHasNoPartnerIsHandedBackAndCounted) {
  PairByTime pairs(15ms, 4);
  EXPECT_EQ(run(pairs, {"c0", "d33", "c33", "c66", "c100", "d100"}), "c0 33+33 c66 100+100 ");
  EXPECT_EQ(pairs.unmatched(), 2u);
}

TEST(PairByTime, TheNearestOfThoseThatArrivedIsTaken) {
  PairByTime pairs(40ms, 4);
  EXPECT_EQ(run(pairs, {"c0", "c30", "d28", "c60"}), "c0 30+28 ");
  EXPECT_EQ(run(pairs, {"d80"}), "60+80 ");
}

TEST(PairByTime, ALateImageWhosePartnersAreGoneIsLone) {
  PairByTime pairs(15ms, 4);
  EXPECT_EQ(run(pairs, {"c0", "d0", "c100", "d101", "d102", "d103"}), "0+0 100+101 ");
  EXPECT_EQ(run(pairs, {"c120"}), "d102 d103 ");
}

TEST(PairByTime, AFullRoomGivesUpTheOldest) {
  PairByTime pairs(15ms, 2);
  EXPECT_EQ(run(pairs, {"c0", "c33", "c66", "c99", "d99"}), "c0 c33 c66 99+99 ");
}

TEST(PairByTime, TimesThatDoNotIncreaseAreRefused) {
  PairByTime pairs(15ms, 4);
  EXPECT_EQ(run(pairs, {"c10", "c10", "c5", "d10", "d10", "c10"}), "refused refused 10+10 refused refused ");
  EXPECT_EQ(pairs.unmatched(), 0u);
}

TEST(PairByTime, NothingIsLostOrPairedTwiceWhateverTheTimes) {
  test::Random random(11);
  for (int round = 0; round < 200; ++round) {
    PairByTime pairs(std::chrono::milliseconds(random.integer(0, 40)), static_cast<std::size_t>(random.integer(1, 4)));
    int c = 0, d = 0, added = 0, paired = 0, lone = 0, last_colour = -1, last_depth = -1;
    for (int i = 0; i < 200; ++i) {
      const bool colour = random.next() % 2 == 0;
      int& time = colour ? c : d;
      time += static_cast<int>(random.integer(1, 60));
      ASSERT_TRUE(colour ? pairs.add_colour(at_ms(time)) : pairs.add_depth(at_ms(time)));
      ++added;
      for (auto o = pairs.next(); o.kind != PairByTime::Kind::nothing; o = pairs.next()) {
        if (o.kind != PairByTime::Kind::lone_depth) {
          ASSERT_GT(ms(o.colour), last_colour);
          last_colour = ms(o.colour);
        }
        if (o.kind != PairByTime::Kind::lone_colour) {
          ASSERT_GT(ms(o.depth), last_depth);
          last_depth = ms(o.depth);
        }
        (o.kind == PairByTime::Kind::pair ? paired : lone) += 1;
      }
    }
    ASSERT_EQ(pairs.unmatched(), static_cast<std::uint64_t>(lone));
    ASSERT_LE(added - 2 * paired - lone, 4) << "more wait than there is room for";
    ASSERT_GE(added - 2 * paired - lone, 0);
  }
}

}  // namespace
}  // namespace onemap::hal::imaging
