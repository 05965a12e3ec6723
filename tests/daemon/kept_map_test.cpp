#include "daemon/kept_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "daemon/set_aside.hpp"
#include "support/text_of.hpp"
#include "temp_folder.hpp"

namespace onemap::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

constexpr Instant kKept{1000s};
const std::vector<std::uint8_t> kMap{1, 2, 3, 4}, kOther{5, 6, 7};

class KeptMapTest : public testing::Test {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      all.push_back(entry.path().filename().string());
    return all;
  }
  const test::TempFolder folder_;
  KeptMap map_{folder_.path().string()};
};

TEST_F(KeptMapTest, WhatWasKeptIsThereInTheNextLife) {
  const auto nothing = map_.open();
  ASSERT_TRUE(nothing.ok());
  EXPECT_FALSE(*nothing);
  ASSERT_TRUE(map_.keep(0xabc, kMap, kKept).ok());
  KeptMap next(folder_.path().string());
  const auto kept = next.open();
  ASSERT_TRUE(kept.ok() && *kept);
  EXPECT_EQ((*kept)->digest, 0xabcu);
  EXPECT_EQ(test::text_of((*kept)->file), "\1\2\3\4");
}

TEST_F(KeptMapTest, TheNextOneReplacesIt) {
  ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
  ASSERT_TRUE(map_.keep(2, kOther, kKept).ok());
  EXPECT_THAT(names(), UnorderedElementsAre("settled-map", "map-0000000000000002.omap"));
}

TEST_F(KeptMapTest, IsDueWhenItIsSettledAndAnotherOneAndNotTooOften) {
  EXPECT_TRUE(map_.due(1, true, kKept));
  EXPECT_FALSE(map_.due(1, false, kKept)) << "not settled";
  EXPECT_FALSE(map_.due(0, true, kKept)) << "no map";
  ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
  EXPECT_FALSE(map_.due(1, true, kKept + 1h)) << "kept already";
  EXPECT_FALSE(map_.due(2, true, kKept + 29s));
  EXPECT_TRUE(map_.due(2, true, kKept + 30s));
}

// Between the two files: the new map is there, and the old one counts.
TEST_F(KeptMapTest, ACrashBetweenTheTwoFilesLeavesTheOldOne) {
  ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
  folder_.write("map-0000000000000002.omap", "new");
  KeptMap next(folder_.path().string());
  const auto kept = next.open();
  ASSERT_TRUE(kept.ok() && *kept);
  EXPECT_EQ((*kept)->digest, 1u);
  EXPECT_THAT(names(), UnorderedElementsAre("settled-map", "map-0000000000000001.omap"));
}

TEST_F(KeptMapTest, AMapThatChangedOnTheDiskIsSetAsideAndSaid) {
  ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
  for (const char* text : {"\1\2\3\5", "\1\2\3", ""}) {
    ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
    folder_.write("map-0000000000000001.omap", text);
    KeptMap next(folder_.path().string());
    const auto kept = next.open();
    ASSERT_FALSE(kept.ok());
    EXPECT_THAT(kept.error().text(), HasSubstr("not the one that was written; set aside as "));
    EXPECT_FALSE(next.kept());
    EXPECT_TRUE(next.open().ok()) << "it is said once";
  }
  EXPECT_THAT(names(),
              UnorderedElementsAre("map-0000000000000001.omap.corrupt-1", "map-0000000000000001.omap.corrupt-2",
                                   "map-0000000000000001.omap.corrupt-3"));
}

TEST_F(KeptMapTest, APointerThatIsNoneIsSetAside) {
  for (const char* text : {"", "1", "zz 4 1\n", "0000000000000001 4 1\n", "../../etc/passwd 4 1\n"}) {
    folder_.write("settled-map", text);
    const auto kept = map_.open();
    ASSERT_FALSE(kept.ok()) << text;
    EXPECT_THAT(kept.error().text(), HasSubstr("does not say which map is kept; set aside as ")) << text;
  }
  ASSERT_TRUE(map_.keep(1, kMap, kKept).ok());
  std::filesystem::remove(folder_.path() / "map-0000000000000001.omap");
  EXPECT_THAT(map_.open().error().text(), HasSubstr("No such file"));
  EXPECT_TRUE(map_.open().ok());
}

TEST(KeptMap, AFolderThatCannotBeWrittenIsAnErrorAndNotTriedAllTheTime) {
  KeptMap map("/nonexistent/place");
  EXPECT_FALSE(map.keep(1, kMap, kKept).ok());
  EXPECT_FALSE(map.kept());
  EXPECT_FALSE(map.due(1, true, kKept + 10s));
  EXPECT_TRUE(map.due(1, true, kKept + 30s));
}

TEST(SetAside, TakesTheNextNumberAndAtLastTheLast) {
  const test::TempFolder folder;
  for (int i = 1; i <= 11; ++i) {
    folder.write("life", std::to_string(i));
    const auto name = set_aside(folder / "life");
    ASSERT_TRUE(name.ok());
    EXPECT_EQ(*name, folder / ("life.corrupt-" + std::to_string(std::min(i, 9))));
    EXPECT_EQ(test::text_of(*name), std::to_string(i));
  }
  EXPECT_THAT(set_aside(folder / "none").error().text(), HasSubstr("none: cannot be set aside: No such file"));
}

}  // namespace
}  // namespace onemap::daemon
