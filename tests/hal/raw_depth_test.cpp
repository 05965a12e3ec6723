#include "hal/imaging/raw_depth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Depth = std::vector<std::uint16_t>;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(RawDepth, Z16IsLittleEndianWithAnyStride) {
  const Bytes raw{0x34, 0x12, 0xFF, 0xFF, 99, 99, 0, 0, 1, 0};
  Depth depth(4);
  ASSERT_TRUE(z16_to_depth({raw, {2, 2}, 6}, depth).ok());
  EXPECT_THAT(depth, ElementsAre(0x1234, 0xFFFF, 0, 1));
  clear_value(0xFFFF, depth);
  EXPECT_THAT(depth, ElementsAre(0x1234, 0, 0, 1));
}

TEST(RawDepth, EveryLengthOfZ16HasAnAnswer) {
  Depth depth(6);
  for (std::size_t size = 0; size < 16; ++size)
    EXPECT_EQ(z16_to_depth({Bytes(size), {3, 2}}, depth).ok(), size >= 12) << size;
  const Status status = z16_to_depth({Bytes(11), {3, 2}}, depth);
  EXPECT_THAT(status.error().reason, HasSubstr("11 bytes, a 3x2 one has 12"));
}

// Bit by bit: pixel i's bits are 11 i to 11 i + 10 of the stream, high bits first.
std::uint16_t disparity_reference(const Bytes& raw, std::size_t pixel) {
  unsigned value = 0;
  for (std::size_t bit = 11 * pixel; bit < 11 * pixel + 11; ++bit)
    value = value << 1 | ((raw[bit / 8] >> (7 - bit % 8)) & 1u);
  return static_cast<std::uint16_t>(value);
}

TEST(RawDepth, PackedDisparityIsUnpackedBitByBit) {
  test::Random random(3);
  Bytes raw(11 * 30);
  for (std::uint8_t& b : raw) b = static_cast<std::uint8_t>(random.next());
  Depth disparity(240);
  ASSERT_TRUE(unpack_disparity11({raw, {24, 10}}, disparity).ok());
  for (std::size_t i = 0; i < disparity.size(); ++i) ASSERT_EQ(disparity[i], disparity_reference(raw, i)) << i;
}

TEST(RawDepth, EveryLengthOfPackedDisparityHasAnAnswer) {
  Depth disparity(16);
  for (std::size_t size = 0; size < 26; ++size)
    EXPECT_EQ(unpack_disparity11({Bytes(size, 0xA5), {8, 2}}, disparity).ok(), size >= 22) << size;
  Depth odd(9);
  EXPECT_THAT(unpack_disparity11({Bytes(99), {9, 1}}, odd).error().reason, HasSubstr("multiple of 8"));
}

TEST(RawDepth, KinectDisparityIsItsFormula) {
  const KinectDisparity kinect;
  Depth all(4096);
  for (std::size_t d = 0; d < all.size(); ++d) all[d] = static_cast<std::uint16_t>(d);
  Depth mm(all.size());
  kinect.to_mm(all, mm);
  for (std::size_t d = 0; d < all.size(); ++d) {
    const double z = d < 1090 ? 348e3 / (1090.0 - static_cast<double>(d)) : 0;
    ASSERT_EQ(mm[d], z > 10000 ? 0 : std::lround(z)) << d;
  }
  EXPECT_EQ(mm[742], 1000);
  Bytes raw(11 * 30);
  test::Random random(8);
  for (std::uint8_t& b : raw) b = static_cast<std::uint8_t>(random.next());
  Depth packed_mm(240);
  ASSERT_TRUE(kinect.packed_to_mm({raw, {24, 10}}, packed_mm).ok());
  for (std::size_t i = 0; i < 240; ++i) ASSERT_EQ(packed_mm[i], mm[disparity_reference(raw, i)]) << i;
  packed_mm.resize(264);
  EXPECT_THAT(kinect.packed_to_mm({raw, {24, 11}}, packed_mm).error().reason, HasSubstr("330 bytes where 363"));
  kinect.to_mm(all, all);  // in place
  EXPECT_EQ(all, mm);
}

}  // namespace
}  // namespace onemap::hal::imaging
