#include "hal/base/bytes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace onemap {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Bytes, IntegersAreLittleEndian) {
  Bytes out;
  ByteWriter writer(out);
  writer.put<std::uint8_t>(0xAB);
  writer.put<std::uint16_t>(0x0123);
  writer.put<std::int32_t>(-2);
  writer.put<std::uint64_t>(0x0102030405060708u);
  EXPECT_EQ(out, (Bytes{0xAB, 0x23, 0x01, 0xFE, 0xFF, 0xFF, 0xFF, 8, 7, 6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(writer.size(), 15u);
}

template <class T>
void expect_round_trip() {
  for (const T value : {std::numeric_limits<T>::min(), std::numeric_limits<T>::max(), T{0}, T{1}, T(-1)}) {
    Bytes out;
    ByteWriter(out).put(value);
    ASSERT_EQ(out.size(), sizeof(T));
    ByteReader reader(out);
    EXPECT_EQ(reader.get<T>(), value);
    EXPECT_TRUE(reader.done());
  }
}

TEST(Bytes, EveryWidthComesBack) {
  expect_round_trip<std::int8_t>();
  expect_round_trip<std::uint8_t>();
  expect_round_trip<std::int16_t>();
  expect_round_trip<std::uint16_t>();
  expect_round_trip<std::int32_t>();
  expect_round_trip<std::uint32_t>();
  expect_round_trip<std::int64_t>();
  expect_round_trip<std::uint64_t>();
}

TEST(Bytes, RunsComeBack) {
  Bytes out;
  ByteWriter writer(out);
  writer.bytes(Bytes{1, 2, 3});
  writer.put<std::uint8_t>(4);
  ByteReader reader(out);
  EXPECT_TRUE(std::ranges::equal(reader.bytes(3), Bytes{1, 2, 3}));
  EXPECT_EQ(reader.remaining(), 1u);
  EXPECT_FALSE(reader.done());
  EXPECT_EQ(reader.get<std::uint8_t>(), 4);
  EXPECT_TRUE(reader.done());
  EXPECT_TRUE(reader.bytes(0).empty());
  EXPECT_TRUE(reader.done());
}

TEST(Bytes, ReadingPastTheEndFailsForGood) {
  const Bytes data{1, 2, 3};
  ByteReader reader(data);
  EXPECT_EQ(reader.get<std::uint32_t>(), 0u);
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.get<std::uint8_t>(), 0);  // though a byte was there
  EXPECT_TRUE(reader.bytes(0).empty());
  EXPECT_FALSE(reader.ok());
  EXPECT_FALSE(reader.done());
}

TEST(Bytes, AbsurdLengthsFail) {
  const Bytes data{1, 2, 3};
  ByteReader reader(data);
  reader.get<std::uint8_t>();
  EXPECT_TRUE(reader.bytes(std::numeric_limits<std::size_t>::max()).empty());
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0u);
}

}  // namespace
}  // namespace onemap
