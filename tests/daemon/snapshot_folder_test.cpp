#include "daemon/snapshot_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/temp_folder.hpp"
#include "support/text_of.hpp"

namespace onemap::daemon {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using testing::HasSubstr;

std::string put(SnapshotFolder& folder, std::size_t bytes = 10) {
  const auto place = folder.begin();
  if (!place) return place.error().text();
  std::ofstream(*place + "/picture") << std::string(bytes, 'x');
  const auto published = folder.publish();
  return published ? fs::path(*published).filename().string() : published.error().text();
}

TEST(SnapshotFolder, NumbersGoOnAcrossLivesAndTheNewestIsLinked) {
  const TempFolder folder;
  {
    SnapshotFolder first(folder / "s", 10, 1000);
    EXPECT_EQ(put(first), "000001");
    EXPECT_EQ(put(first), "000002");
    ASSERT_TRUE(first.begin());  // and then its life ends
  }
  SnapshotFolder second(folder / "s", 10, 1000);
  EXPECT_EQ(put(second), "000003");
  EXPECT_EQ(fs::read_symlink(folder / "s/latest"), "000003");
  EXPECT_EQ(test::text_of(folder / "s/latest/picture"), "xxxxxxxxxx");
  EXPECT_FALSE(fs::exists(folder / "s/.partial"));
}

TEST(SnapshotFolder, TheOldestGoWhenThereAreTooMany) {
  const TempFolder folder;
  fs::create_directories(folder / "s/mine");  // not a number: nobody's business
  SnapshotFolder snapshots(folder / "s", 2, 1000);
  for (int i = 0; i < 4; ++i) put(snapshots);
  EXPECT_EQ(snapshots.removed(), 2u);
  EXPECT_FALSE(fs::exists(folder / "s/000002"));
  EXPECT_TRUE(fs::exists(folder / "s/000003"));
  EXPECT_TRUE(fs::exists(folder / "s/000004"));
  EXPECT_TRUE(fs::exists(folder / "s/mine"));
}

TEST(SnapshotFolder, TheDiskLimitHoldsForAllTogether) {
  const TempFolder folder;
  SnapshotFolder snapshots(folder / "s", 100, 100);
  put(snapshots, 40);
  put(snapshots, 40);
  EXPECT_EQ(put(snapshots, 50), "000003");
  EXPECT_FALSE(fs::exists(folder / "s/000001"));
  EXPECT_TRUE(fs::exists(folder / "s/000002"));
  EXPECT_THAT(put(snapshots, 101), HasSubstr("larger than snapshots.disk_limit_mb"));
  EXPECT_TRUE(fs::exists(folder / "s/000003")) << "what there was stays";
  EXPECT_FALSE(fs::exists(folder / "s/.partial"));
}

TEST(SnapshotFolder, APlaceThatTakesNoFoldersIsSaid) {
  const TempFolder folder;
  folder.write("file", "x");
  SnapshotFolder snapshots(folder / "file", 10, 1000);
  EXPECT_THAT(put(snapshots), HasSubstr("cannot make the folder"));
}

}  // namespace
}  // namespace onemap::daemon
