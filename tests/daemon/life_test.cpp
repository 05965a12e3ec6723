#include "daemon/life.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
constexpr std::uint64_t kNow = 1'700'000'000'000'000'000u;

std::uint64_t begin(const TempFolder& folder, std::uint64_t clock) {
  LifeCounter life(folder.path().string());
  EXPECT_TRUE(life.begin(clock).ok());
  return life.number();
}

TEST(Life, TheClockIsTheFirstNumber) {
  const TempFolder folder;
  EXPECT_EQ(begin(folder, kNow), kNow);
}

TEST(Life, AClockThatGoesBackDoesNotMakeAnOlderLife) {
  const TempFolder folder;
  const auto first = begin(folder, kNow);
  const auto second = begin(folder, 5);  // a board without a battery clock: 1970
  const auto third = begin(folder, 5);
  EXPECT_EQ(second, first + 1);
  EXPECT_EQ(third, first + 2);
  EXPECT_EQ(begin(folder, kNow + 100), kNow + 100);
}

TEST(Life, NeighboursMayKnowOfAGreaterOne) {
  const TempFolder folder;
  LifeCounter life(folder.path().string());
  ASSERT_TRUE(life.begin(5).ok());
  ASSERT_TRUE(life.begin_after(kNow).ok());
  EXPECT_EQ(life.number(), kNow + 1);
  EXPECT_EQ(begin(folder, 5), kNow + 2) << "it was kept";
}

TEST(Life, ABrokenFileIsSetAsideAndSaid) {
  const TempFolder folder;
  int number = 0;
  for (const char* text : {"", "x", "12 13", "-4", "99999999999999999999", "9223372036854775808\n"}) {
    folder.write("life", text);
    LifeCounter life(folder.path().string());
    const Status status = life.begin(kNow);
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_THAT(status.error().text(), testing::HasSubstr("life"));
    EXPECT_EQ(life.number(), kNow);
    const std::string aside = folder / ("life.corrupt-" + std::to_string(++number));
    EXPECT_THAT(status.error().text(), testing::HasSubstr("set aside as " + aside));
    EXPECT_EQ(test::text_of(aside), text);
    EXPECT_EQ(test::text_of(folder / "life"), std::to_string(kNow) + "\n");
  }
}

TEST(Life, AFolderThatCannotBeWrittenLeavesTheClocksNumber) {
  LifeCounter life("/nonexistent/place");
  EXPECT_FALSE(life.begin(kNow).ok());
  EXPECT_EQ(life.number(), kNow);
}

}  // namespace
}  // namespace onemap::daemon
