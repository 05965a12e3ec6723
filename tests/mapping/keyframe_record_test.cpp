// What a keyframe's record holds: bytes, bounds and errors of the coding.
#include "mapping/records/keyframe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <cmath>

#include "support/random.hpp"

namespace onemap::mapping {
namespace {

using test::Random;
using Bytes = std::vector<std::uint8_t>;

// A wall, a table before it and holes, with a sensor's noise of one step.
KeyframeRecord desk(int width = 160, int height = 120, int features = 400) {
  Random random(3);
  KeyframeRecord out;
  out.grid.width = static_cast<std::uint16_t>(width);
  out.grid.height = static_cast<std::uint16_t>(height);
  out.grid.fx_fy_cx_cy = {132 << 10, 132 << 10, 80 << 10, 60 << 10};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const bool hole = (u / 9 + v / 7) % 5 == 0, table = v > 70 && u > 30 && u < 140;
      const int q = (table ? 500 + 2 * (v - 70) : 200 + u / 16) + static_cast<int>(random.integer(-1, 1));
      out.grid.inverse_depth.push_back(static_cast<std::uint16_t>(hole ? 0 : q));
    }
  for (int i = 0; i < features; ++i) {
    KeyframeFeature f;
    f.place = {static_cast<std::uint16_t>(random.integer(1536, 6655)),
               static_cast<std::uint16_t>(random.integer(2176, 6015)),
               static_cast<std::uint16_t>(random.integer(300, 1200))};
    f.laplacian = static_cast<std::int8_t>(2 * random.integer(0, 1) - 1);
    for (auto& word : f.bits) word = random.next();
    out.features.push_back(f);
  }
  return out;
}

void expect_refused(const Bytes& body, const char* why) {
  const auto result = decode_keyframe(body);
  ASSERT_FALSE(result.ok()) << why;
  EXPECT_THAT(result.error().text(), testing::HasSubstr(why));
}

// Where the grid's compressed part begins.
std::size_t frame_at(const KeyframeRecord& record) { return 4 + 8 + 28 + 4 + 1 + 2 + 37 * record.features.size() + 20; }

// The body with another content in place of the grid's.
Bytes with_content(const KeyframeRecord& record, const Bytes& content) {
  Bytes body = encode(record), frame(ZSTD_compressBound(content.size()));
  frame.resize(ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), 3));
  body.resize(frame_at(record));
  body.insert(body.end(), frame.begin(), frame.end());
  return body;
}

TEST(KeyframeCoding, AFeatureTakes37BytesAndTheGridLittle) {
  const KeyframeRecord record = desk();
  const Bytes body = encode(record);
  const std::size_t grid = body.size() - frame_at(record);
  EXPECT_GT(grid, 2000u) << "a bit of noise is in most of 15,000 cells";
  EXPECT_LT(grid, 6000u) << "less than a sixth of two bytes a cell";
}

// All or nothing: what a flipped byte leaves of the record is an error that names the field, or another record that is
// as well formed and of the same size.
TEST(KeyframeCoding, EveryByteFlippedIsRefusedOrAnotherRecord) {
  const KeyframeRecord record = desk(48, 40, 30);
  const Bytes body = encode(record);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < body.size(); ++i)
    for (const std::uint8_t flip : {0x01, 0x80}) {
      Bytes other = body;
      other[i] ^= flip;
      const auto out = decode_keyframe(other);
      if (!out.ok()) {
        ++refused;
        EXPECT_THAT(out.error().text(), testing::StartsWith("keyframe record, "));
        continue;
      }
      EXPECT_EQ(out->features.size(), record.features.size());
      EXPECT_EQ(out->grid.inverse_depth.size(), record.grid.inverse_depth.size());
      if (i < frame_at(record)) {
        EXPECT_EQ(encode(*out), other) << "byte " << i;
      }
    }
  EXPECT_GT(refused, 100u);
}

TEST(KeyframeCoding, SaysWhichFieldBreaksItsBound) {
  const KeyframeRecord good = desk();
  ASSERT_TRUE(decode_keyframe(encode(good)).ok());
  KeyframeRecord bad = good;
  bad.descriptor_kind = DescriptorKind::surf;
  expect_refused(encode(bad), "descriptor_kind: unknown");
  bad = good;
  bad.descriptor_kind = DescriptorKind::orb;
  expect_refused(encode(bad), "features.place: a Laplacian, which ORB has not");
  bad = good;
  bad.anchor = bad.index + 1;
  expect_refused(encode(bad), "anchor: a later keyframe");
  bad = good;
  bad.features[7].place.inverse_depth = 0;
  expect_refused(encode(bad), "features.place: not in front of the camera");
  bad = good;
  bad.features.resize(1001, bad.features[0]);
  expect_refused(encode(bad), "features: more than allowed");
  bad = good;
  bad.grid.fx_fy_cx_cy[1] = 0;
  expect_refused(encode(bad), "grid.fx_fy_cx_cy: focal length not positive");
  bad = good;
  bad.grid.width = 161;
  bad.grid.inverse_depth.resize(std::size_t{161} * 120, 100);
  expect_refused(encode(bad), "grid.width: larger than 160 x 120");
  for (const std::uint16_t q : {DepthGrid::kFarthest - 1, DepthGrid::kNearest + 1}) {
    bad = good;
    bad.grid.inverse_depth[0] = q;
    expect_refused(encode(bad), "grid.depth: out of range");
  }
}

// A body cannot make its reader take or do more than an honest one of that grid.
TEST(KeyframeCoding, TheGridsContentHasTheSizeThatItsCellsCanHave) {
  KeyframeRecord record = desk();
  record.grid.width = 10;
  record.grid.height = 3;
  record.grid.inverse_depth.assign(30, 100);
  Bytes content(4 + 2 * 30);
  content[0] = content[1] = content[2] = 0xFF;
  content[3] = 0x3F;
  content[4] = 200;  // the first depth: 100, zigzagged
  ASSERT_TRUE(decode_keyframe(with_content(record, content)).ok());
  expect_refused(with_content(record, Bytes(3)), "content of another size");
  expect_refused(with_content(record, Bytes(65)), "content of another size");
  expect_refused(with_content(record, Bytes(std::size_t{1} << 24)), "content of another size");
  content[3] = 0x7F;
  expect_refused(with_content(record, content), "bits beyond the last cell");
  content[3] = 0x1F;
  expect_refused(with_content(record, content), "not as many depths as the mask says");
  Bytes twice = encode(record);
  const Bytes frame(twice.begin() + static_cast<std::ptrdiff_t>(frame_at(record)), twice.end());
  twice.insert(twice.end(), frame.begin(), frame.end());
  expect_refused(twice, "not one zstd frame");
  Bytes padded = encode(record);
  padded.resize(padded.size() + 5000);
  expect_refused(padded, "longer than the cells can need");
  Bytes unknown = encode(record);
  unknown.resize(frame_at(record) + 2);
  expect_refused(unknown, "not a sized zstd frame");
}

TEST(KeyframeCoding, AGridWithoutCellsHasNoContent) {
  KeyframeRecord record = desk();
  record.grid = {};
  Bytes body = encode(record);
  ASSERT_TRUE(decode_keyframe(body).ok());
  body.push_back(0);
  expect_refused(body, "end: bytes follow");
}

TEST(FeaturePlaces, AreAnEighthOfAPixelAndAMillimetreInTheInverse) {
  DepthGrid grid = desk().grid;
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const double z = random.uniform(0.3, 6);
    const Vector3d p((random.uniform(0, 160) - 80) / 132 * z, (random.uniform(0, 120) - 60) / 132 * z, z);
    const auto place = to_place(p, grid);
    ASSERT_TRUE(place.has_value());
    const Vector3d back = place_point(*place, grid);
    EXPECT_NEAR(1 / back.z(), 1 / z, 0.00051);
    EXPECT_LT((place_ray(*place, grid) - p.head<2>() / z).cwiseAbs().maxCoeff() * 132 * 4, 0.0626) << "image pixels";
    EXPECT_LT((back.head<2>() / back.z() - place_ray(*place, grid)).norm(), 1e-12);
    EXPECT_EQ(to_place(back, grid), place) << "coding again changes nothing";
  }
}

TEST(FeaturePlaces, WhatTheyCannotSayIsNone) {
  const DepthGrid grid = desk().grid;
  EXPECT_TRUE(to_place({0, 0, 0.1225}, grid));
  EXPECT_FALSE(to_place({0, 0, 0.1220}, grid)) << "too near";
  EXPECT_FALSE(to_place({0, 0, 0}, grid));
  EXPECT_FALSE(to_place({0, 0, -1}, grid));
  EXPECT_FALSE(to_place({0, 0, std::nan("")}, grid));
  EXPECT_TRUE(to_place({127.0 / 132, 0, 1}, grid)) << "outside the grid: a wide lens";
  EXPECT_FALSE(to_place({129.0 / 132, 0, 1}, grid));
  EXPECT_FALSE(to_place({0, -129.0 / 132, 1}, grid));
}

TEST(DepthGrids, DepthsAreWithinAMillimetreTimesTheirSquare) {
  for (double z = 0.051; z < 8; z *= 1.003) {
    const std::uint16_t q = grid_inverse_depth(z);
    EXPECT_NEAR(grid_depth_m(q), z, 0.00102 * z * z) << z;
  }
  EXPECT_EQ(grid_inverse_depth(0), 0);
  EXPECT_EQ(grid_inverse_depth(0.04), 0);
  EXPECT_EQ(grid_inverse_depth(9), 0);
  EXPECT_EQ(grid_depth_m(0), 0);
}

}  // namespace
}  // namespace onemap::mapping
