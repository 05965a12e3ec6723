#include "hal/imaging/tabled_registration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hal/base/twin.hpp"
#include "hal/imaging/raw_depth.hpp"
#include "places.hpp"
#include "support/random.hpp"

namespace onemap::hal::imaging {
namespace {

constexpr ImageSize kImage{48, 20};

struct OwnedTables {
  std::vector<std::uint16_t> mm = std::vector<std::uint16_t>(2048);
  std::vector<std::int32_t> shift = std::vector<std::int32_t>(10000);
  std::vector<std::int32_t> places;
  std::int32_t less = 0;
  FactoryTables view() const { return {mm, shift, places, less}; }
};

// As of a device: depths that grow with the disparity up to the horizon, at 1090, and nonsense behind it; parallax; a
// lens that bends a little, beyond the image's sides, too.
OwnedTables like_a_device(std::uint64_t seed) {
  test::Random random(seed);
  OwnedTables of;
  for (std::size_t d = 0; d < of.mm.size(); ++d)
    of.mm[d] = static_cast<std::uint16_t>(d < 1090 ? std::min(348e3 / (1090.0 - static_cast<double>(d)), 65000.0)
                                                   : random.integer(0, 9000));
  for (std::size_t z = 1; z < of.shift.size(); ++z)
    of.shift[z] = static_cast<std::int32_t>(256 * (2.0 - 2400.0 / static_cast<double>(z)));
  for (int v = 0; v < kImage.height; ++v)
    for (int u = 0; u < kImage.width; ++u) {
      of.places.push_back(static_cast<std::int32_t>(256 * (u + random.uniform(-2, 2))));
      of.places.push_back(v + static_cast<std::int32_t>(random.integer(-1, 1)));
      if (random.next() % 20 == 0) of.places[of.places.size() - 2] = 2 * kImage.width * 256;  // libfreenect's "nowhere"
    }
  return of;
}

std::vector<std::uint8_t> packed_disparities(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<std::uint8_t> out;
  std::uint32_t bits = 0;
  int have = 0;
  for (std::size_t i = 0; i < kImage.pixels(); ++i) {
    const auto near = static_cast<std::uint32_t>(600 + 5 * (i % 48) + random.next() % 4);
    const auto any = static_cast<std::uint32_t>(random.next() % 2048);
    bits = bits << 11 | (random.next() % 8 == 0 ? 2047u : random.next() % 8 == 0 ? any : near);
    for (have += 11; have >= 8; have -= 8) out.push_back(static_cast<std::uint8_t>(bits >> (have - 8)));
  }
  return out;
}

// As libfreenect's registration.c does it, pixel by pixel, with every place looked at before it is touched.
std::vector<std::uint16_t> one_by_one(const OwnedTables& of, const std::vector<std::uint8_t>& packed) {
  std::vector<std::uint16_t> disparity(kImage.pixels()), out(kImage.pixels(), 0);
  EXPECT_TRUE(unpack_disparity11({packed, kImage}, disparity).ok());
  const auto horizon =
      static_cast<std::size_t>(std::ranges::adjacent_find(of.mm, [](auto a, auto b) { return b < a; }) - of.mm.begin());
  for (std::size_t i = 0; i < disparity.size(); ++i) {
    const std::uint16_t mm = of.mm[disparity[i]];
    if (disparity[i] > horizon || mm == 0 || mm >= 10000) continue;
    const int right = of.places[2 * i] + of.shift[mm], row = of.places[2 * i + 1];
    const int column = right / 256, at = row * kImage.width + column - of.less;
    if (column < 0 || column >= kImage.width || row < 0 || row >= kImage.height) continue;
    if (at < 0 || at >= static_cast<int>(out.size())) continue;
    std::uint16_t& there = out[static_cast<std::size_t>(at)];
    if (there == 0 || there > mm) there = mm;
  }
  return out;
}

TEST(TabledRegistration, IsWhatLibfreenectsLoopGives) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    OwnedTables of = like_a_device(seed);
    of.less = seed == 3 ? 3 * kImage.height : 0;
    const auto packed = packed_disparities(seed + 10);
    std::vector<std::uint16_t> out(kImage.pixels(), 77);
    ASSERT_TRUE(TabledRegistration(kImage, of.view()).apply(packed, out).ok());
    EXPECT_EQ(out, one_by_one(of, packed));
    EXPECT_GT(std::ranges::count_if(out, [](auto mm) { return mm > 0; }), 400);
  }
}

// Tables of a device that lies: nothing outside the image is touched, which the address sanitizer sees.
TEST(TabledRegistration, AnyTablesHaveAnAnswer) {
  test::Random random(9);
  for (int round = 0; round < 20; ++round) {
    OwnedTables of = like_a_device(static_cast<std::uint64_t>(round));
    for (auto& shift : of.shift)
      if (random.next() % 3 == 0) shift = static_cast<std::int32_t>(random.next());
    for (auto& place : of.places)
      if (random.next() % 3 == 0) place = static_cast<std::int32_t>(random.next());
    of.less = static_cast<std::int32_t>(random.integer(0, 2000));
    if (round % 4 == 0) of.mm.resize(700), of.shift.resize(900), of.places.resize(kImage.pixels());
    std::vector<std::uint16_t> out(kImage.pixels());
    EXPECT_TRUE(TabledRegistration(kImage, of.view()).apply(packed_disparities(7), out).ok());
    EXPECT_TRUE(std::ranges::all_of(out, [](auto mm) { return mm < 10000; }));
  }
  TabledRegistration none(kImage, {});
  std::vector<std::uint16_t> out(kImage.pixels(), 5);
  ASSERT_TRUE(none.apply(packed_disparities(7), out).ok());
  EXPECT_TRUE(std::ranges::all_of(out, [](auto mm) { return mm == 0; }));
}

TEST(TabledRegistration, AShortImageIsAnErrorThatSaysIt) {
  TabledRegistration registration(kImage, like_a_device(1).view());
  std::vector<std::uint16_t> out(kImage.pixels());
  auto packed = packed_disparities(1);
  packed.pop_back();
  EXPECT_THAT(registration.apply(packed, out).error().reason, testing::HasSubstr("1319 bytes where 1320 are expected"));
}

TEST(TabledRegistration, TheTwinsFindTheSamePlaces) {
  if (!simd_available()) GTEST_SKIP() << "this CPU has no AVX2";
  test::Random random(4);
  places::Table table{{}, 640, 640 * 480, 11};
  for (int d = 0; d < 2048; ++d) table.readings.push_back(static_cast<std::int32_t>(random.next()));
  for (std::size_t width = 1; width < 70; ++width) {
    std::vector<std::uint16_t> disparity(width);
    std::vector<places::Moved> moved(width);
    for (std::size_t i = 0; i < width; ++i) {
      disparity[i] = static_cast<std::uint16_t>(random.next() % 2048);
      if (random.next() % 9 != 0)
        moved[i] = {static_cast<std::int16_t>(random.next()), static_cast<std::int16_t>(random.next() % 500)};
    }
    const places::Row row{640 * 17, disparity, moved.data()};
    std::vector<std::int32_t> plain(width), simd(width);
    std::vector<std::uint16_t> plain_1(width), simd_1(width);
    places::find_plain(table, row, plain.data(), plain_1.data());
    places::find_simd(table, row, simd.data(), simd_1.data());
    EXPECT_EQ(plain, simd);
    EXPECT_EQ(plain_1, simd_1);
    EXPECT_TRUE(std::ranges::all_of(plain, [](auto at) { return at >= 0 && at < 640 * 480; }));
  }
}

}  // namespace
}  // namespace onemap::hal::imaging
