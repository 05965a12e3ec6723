#include "fetch/assembly.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <numeric>

namespace onemap::comms {
namespace {

struct Source {
  std::vector<std::uint8_t> body;
  explicit Source(std::size_t bytes) : body(bytes) { std::iota(body.begin(), body.end(), std::uint8_t{0}); }
  wire::Data fragment(std::uint16_t index, std::uint8_t hops = 0) const {
    wire::Data data;
    data.kind = 7;
    data.hops = hops;
    data.total_bytes = static_cast<std::uint32_t>(body.size());
    data.body_hash = wire::body_hash(7, body);
    data.fragment = index;
    const std::size_t at = index * wire::kFragmentBytes;
    data.bytes = std::span(body).subspan(at, std::min(wire::kFragmentBytes, body.size() - at));
    return data;
  }
};

TEST(Assembly, PutsFragmentsTogetherInAnyOrder) {
  const Source source(3000);
  Assembly record;
  record.begin(8);  // more than there are
  EXPECT_EQ(record.missing(), 8u);
  for (std::uint32_t k = 0; k < 8; ++k) record.asked(k, 100 + k);
  EXPECT_EQ(record.missing(), 0u);
  record.learn(source.fragment(2));
  EXPECT_EQ(record.fragments(), 3u);
  EXPECT_EQ(record.serial_of(1), 101u);
  EXPECT_EQ(record.keep(source.fragment(2, 4)), Assembly::Kept::first);
  EXPECT_EQ(record.keep(source.fragment(2)), Assembly::Kept::again);
  EXPECT_EQ(record.keep(source.fragment(0)), Assembly::Kept::first);
  EXPECT_FALSE(record.complete());
  EXPECT_EQ(record.keep(source.fragment(1)), Assembly::Kept::first);
  EXPECT_TRUE(record.complete());
  EXPECT_TRUE(record.hash_is_right());
  EXPECT_TRUE(std::ranges::equal(record.body(), source.body));
  EXPECT_EQ(record.kind(), 7);
  EXPECT_EQ(record.hops(), 5) << "one more than the longest way";
}

TEST(Assembly, GrowsWhenTheGuessWasTooSmall) {
  Assembly record;
  record.begin(1);
  record.asked(0, 5);
  record.learn(Source(5000).fragment(0));
  EXPECT_EQ(record.fragments(), 5u);
  EXPECT_EQ(record.missing(), 4u);
}

TEST(Assembly, WhatIsLostOrWithdrawnIsMissingAgain) {
  const Source source(3000);
  Assembly record;
  record.begin(3);
  for (std::uint32_t k = 0; k < 3; ++k) record.asked(k, k + 1);
  record.lost(1);
  record.lost(1);
  record.lost(17);
  EXPECT_EQ(record.missing(), 1u);
  record.learn(source.fragment(0));
  record.keep(source.fragment(0));
  record.withdrawn();
  EXPECT_EQ(record.missing(), 2u);
  EXPECT_FALSE(record.is_missing(0));
}

TEST(Assembly, NoticesContradictionsAndStartsAnew) {
  const Source source(3000);
  Assembly record;
  record.begin(3);
  record.learn(source.fragment(0));
  record.keep(source.fragment(0, 9));
  auto other = source.fragment(1);
  EXPECT_TRUE(record.agrees(other));
  other.kind = 8;
  EXPECT_FALSE(record.agrees(other));
  other = source.fragment(1);
  other.body_hash ^= 1;
  EXPECT_FALSE(record.agrees(other));
  EXPECT_FALSE(record.agrees(Source(3001).fragment(1)));
  record.restart();
  EXPECT_FALSE(record.known());
  EXPECT_EQ(record.missing(), 3u);
  EXPECT_EQ(record.hops(), 0);
}

TEST(Assembly, SpoiltBytesShow) {
  Source source(100);
  const auto good = source.fragment(0);
  Assembly record;
  record.begin(1);
  record.learn(good);
  source.body[50] ^= 1;
  auto spoilt = good;
  spoilt.bytes = source.body;
  record.keep(spoilt);
  EXPECT_TRUE(record.complete());
  EXPECT_FALSE(record.hash_is_right());
}

TEST(Assembly, AnEmptyBodyIsARecord) {
  const Source source(0);
  Assembly record;
  record.begin(1);
  record.learn(source.fragment(0));
  record.keep(source.fragment(0));
  EXPECT_TRUE(record.complete());
  EXPECT_TRUE(record.hash_is_right());
}

}  // namespace
}  // namespace onemap::comms
