// What a surface costs to store and to send.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

TEST(SubmapBytes, AnObservedVoxelTakesAtMostTwo) {
  std::size_t bytes = 0, observed = 0;
  for (const RecordPtr& record : test::first().written()) {
    if (record->kind != static_cast<std::uint16_t>(RecordKind::submap)) continue;
    const auto submap = decode_submap(record->body);
    ASSERT_TRUE(submap.ok()) << submap.error().text();
    bytes += record->body.size();
    for (const SubmapBlock& block : submap->blocks)
      observed += static_cast<std::size_t>(
          std::ranges::count_if(block.voxels, [](const SubmapVoxel& voxel) { return voxel.weight > 0; }));
  }
  ASSERT_GT(observed, 100'000u);
  const double of_each = static_cast<double>(bytes) / static_cast<double>(observed);
  fmt::print("{} observed voxels in {} bytes: {:.2f} each\n", observed, bytes, of_each);
  EXPECT_LE(of_each, 2.0);
}

}  // namespace
}  // namespace onemap::mapping
