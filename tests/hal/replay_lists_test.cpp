#include "hal/backends/replay/lists.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

namespace onemap::hal::replay {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(ReplayTime, IsExactToTheNanosecond) {
  EXPECT_EQ(*parse_time("1305031102.175304"), frame_time_from_ns(1305031102175304000));
  EXPECT_EQ(*parse_time("0"), frame_time_from_ns(0));
  EXPECT_EQ(*parse_time("7."), frame_time_from_ns(7'000'000'000));
  EXPECT_EQ(*parse_time("0.0000000019"), frame_time_from_ns(1));
  EXPECT_EQ(*parse_time("9000000000.999999999"), frame_time_from_ns(9'000'000'000'999'999'999));
}

TEST(ReplayTime, OtherTextIsRefused) {
  for (const char* text : {"", ".", ".5", "-1", "+1", "1e9", "1.2.3", "1,5", "nan", "12x", "0x10", "9000000001",
                           "99999999999999999999999999"})
    EXPECT_FALSE(parse_time(text).ok()) << text;
}

TEST(ReplayLists, CommentsBlankLinesAndCrlfAreFine) {
  const ImageList list = parse_image_list("# time path\r\n\r\n  2.5\trgb/b.png  # why\r\n1 rgb/a.png", "rgb.txt");
  EXPECT_TRUE(list.problems.empty());
  ASSERT_EQ(list.images.size(), 2u);
  EXPECT_EQ(list.images[0].path, "rgb/a.png");  // sorted by time
  EXPECT_EQ(list.images[0].line, 4);
  EXPECT_EQ(list.images[1].path, "rgb/b.png");
  EXPECT_EQ(list.images[1].time, frame_time_from_ns(2'500'000'000));
}

TEST(ReplayLists, UnusableLinesAreNamedAndLeftOut) {
  const ImageList list = parse_image_list("1 a\nbroken\n2 b c\nx d\n3 e\n1 f\n", "D/rgb.txt");
  ASSERT_EQ(list.images.size(), 2u);
  EXPECT_EQ(list.images[0].path, "a");
  EXPECT_EQ(list.images[1].path, "e");
  ASSERT_EQ(list.problems.size(), 4u);
  EXPECT_EQ(list.problems[0].place, "D/rgb.txt:2");
  EXPECT_EQ(list.problems[1].place, "D/rgb.txt:3");
  EXPECT_EQ(list.problems[2].text(), "D/rgb.txt:4: 'x' is not a time in seconds");
  EXPECT_EQ(list.problems[3].text(), "D/rgb.txt:6: the same time as in line 1");
}

TEST(ReplayLists, AssociationsInEitherOrder) {
  const PairList list =
      parse_associations("2 rgb/2.png 2.01 depth/2.png\n1 depth/1.png 1.01 rgb/1.png\n3 rgb/3.png\n", "a");
  ASSERT_EQ(list.pairs.size(), 2u);
  EXPECT_EQ(list.pairs[0].color.path, "rgb/1.png");
  EXPECT_EQ(list.pairs[0].color.time, frame_time_from_ns(1'010'000'000));
  EXPECT_EQ(list.pairs[0].depth.path, "depth/1.png");
  EXPECT_EQ(list.pairs[1].color.path, "rgb/2.png");
  ASSERT_EQ(list.problems.size(), 1u);
  EXPECT_EQ(list.problems[0].place, "a:3");
}

std::vector<ListedImage> at_ms(const std::vector<int>& times) {
  std::vector<ListedImage> images;
  for (const int ms : times) images.push_back({frame_time_from_ns(ms * 1'000'000LL), std::to_string(ms), 0});
  return images;
}

std::vector<std::pair<int, int>> pairs_ms(const std::vector<int>& color, const std::vector<int>& depth) {
  std::vector<std::pair<int, int>> pairs;
  for (const ListedPair& pair : associate(at_ms(color), at_ms(depth), 20ms))
    pairs.emplace_back(std::stoi(pair.color.path), std::stoi(pair.depth.path));
  return pairs;
}

using Pairs = std::vector<std::pair<int, int>>;

TEST(ReplayAssociate, TakesTheNearestAndEachOnce) {
  EXPECT_EQ(pairs_ms({100, 133, 166}, {90, 120, 160}), (Pairs{{100, 90}, {133, 120}, {166, 160}}));
  EXPECT_EQ(pairs_ms({100, 110}, {109}), (Pairs{{110, 109}}));                   // the nearer colour gets it
  EXPECT_EQ(pairs_ms({100, 110}, {108, 118}), (Pairs{{100, 118}, {110, 108}}));  // the closest pair first, at any price
  EXPECT_EQ(pairs_ms({100}, {80, 121}), (Pairs{{100, 80}}));                     // 20 ms is near enough, 21 is not
  EXPECT_EQ(pairs_ms({100}, {121}), Pairs{});
  EXPECT_EQ(pairs_ms({}, {1}), Pairs{});
}

// TUM's associate.py, word for word: all candidates, sorted, greedily.
Pairs plain_reference(std::vector<int> color, std::vector<int> depth) {
  std::vector<std::tuple<int, int, int>> candidates;
  for (const int a : color)
    for (const int b : depth)
      if (std::abs(a - b) <= 20) candidates.emplace_back(std::abs(a - b), a, b);
  std::sort(candidates.begin(), candidates.end());
  Pairs pairs;
  for (const auto& [difference, a, b] : candidates) {
    const auto in_a = std::find(color.begin(), color.end(), a);
    const auto in_b = std::find(depth.begin(), depth.end(), b);
    if (in_a == color.end() || in_b == depth.end()) continue;
    color.erase(in_a);
    depth.erase(in_b);
    pairs.emplace_back(a, b);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(ReplayAssociate, AgreesWithThePlainReference) {
  std::uint32_t state = 1;
  const auto next = [&] { return state = state * 1664525u + 1013904223u, state >> 16; };
  for (int round = 0; round < 200; ++round) {
    std::vector<int> lists[2];
    for (auto& list : lists) {
      const std::uint32_t gap = 5 + next() % 40;
      for (int t = 0; t < 1000; t += 1 + static_cast<int>(next() % gap)) list.push_back(t);
    }
    ASSERT_EQ(pairs_ms(lists[0], lists[1]), plain_reference(lists[0], lists[1])) << "round " << round;
  }
}

}  // namespace
}  // namespace onemap::hal::replay
