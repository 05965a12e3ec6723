#include "daemon/pictures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "daemon/saved_map.hpp"
#include "support/program.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;

std::vector<std::uint8_t> one_wall() {
  mapping::VoxelMapConfig config;
  config.budget_bytes = 4u << 20;
  config.image_pixels = 0;
  mapping::VoxelMap map(config);
  for (std::size_t i = 0; i < mapping::kBlockVoxels; ++i) {
    mapping::Voxel& voxel = map.find_or_add({0, 0, 0})[i];
    voxel.add_tsdf(200 * (static_cast<int>(i % 8) - 3), 5);
    voxel.add_color(200, 100, 50);
  }
  return save_map("a wall", {}, map);
}

bool nothing_left_of_the_drawing(const TempFolder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
    if (entry.path().string().find(".drawing.") != std::string::npos) return false;
  return true;
}

TEST(Pictures, EachGetsItsFilesAndSaysWhatTheyHold) {
  const TempFolder folder;
  const auto results = write_pictures({{folder / "a", one_wall()}, {folder / "b", one_wall()}});
  ASSERT_EQ(results.size(), 2u);
  for (const PictureResult& result : results) {
    EXPECT_TRUE(result.status) << result.status.error().text();
    EXPECT_EQ(result.vertices, 64u) << "eight by eight";
  }
  for (const char* file : {"a.png", "a.glb", "a.ply", "a.pcd", "b.png", "b.glb", "b.ply", "b.pcd"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  EXPECT_TRUE(nothing_left_of_the_drawing(folder));
}

TEST(Pictures, OneThatCannotBeDrawnDoesNotKeepTheOthersFromIt) {
  const TempFolder folder;
  auto broken = one_wall();
  broken.resize(broken.size() / 2);
  const auto results = write_pictures({{folder / "bad", broken}, {folder / "good", one_wall()}});
  ASSERT_FALSE(results[0].status);
  EXPECT_THAT(results[0].status.error().text(), HasSubstr("ends in the middle"));
  EXPECT_TRUE(results[1].status);
  EXPECT_TRUE(std::filesystem::exists(folder / "good.png"));
  EXPECT_TRUE(nothing_left_of_the_drawing(folder));
}

TEST(Pictures, AFolderThatIsNotThereIsSaid) {
  const auto results = write_pictures({{"/nonexistent/place/a", one_wall()}});
  ASSERT_FALSE(results[0].status);
  EXPECT_THAT(results[0].status.error().text(), HasSubstr("/nonexistent/place"));
}

TEST(Pictures, ADrawingThatTakesTooMuchIsEndedAndSaid) {
  const TempFolder folder;
  PictureLimits limits;
  limits.time = std::chrono::milliseconds(1);
  EXPECT_THAT(write_pictures({{folder / "a", one_wall()}}, limits)[0].status.error().text(),
              HasSubstr("took too long"));
  limits = {};
  limits.address_space_bytes = 4u << 20;  // not even the program fits
  const auto results = write_pictures({{folder / "a", one_wall()}}, limits);
  ASSERT_FALSE(results[0].status);
  EXPECT_THAT(results[0].status.error().text(), HasSubstr("drawing failed"));
  EXPECT_TRUE(nothing_left_of_the_drawing(folder));
}

}  // namespace
}  // namespace onemap::daemon
