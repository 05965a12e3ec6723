#include "mapping/team/needless_submaps.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

// A robot that was at some anchors, all in one place of its map unless it is said otherwise.
struct Walker {
  // A keyframe that is its own anchor, then one that hangs on it `stays` later.
  std::uint32_t anchor(std::chrono::seconds at, std::chrono::seconds stays = 5s) {
    KeyframeRecord body;
    const std::uint32_t number = keyframes;
    for (const auto since : {0s, stays}) {
      body.index = keyframes++;
      body.anchor = number;
      body.time = FrameTime{} + at + since;
      take(author.write(Lane::features, RecordKind::keyframe, body));
    }
    solved.anchors.push_back({number, {}});
    return number;
  }
  // A wall of 6 x 6 blocks from there on, each voxel seen with this weight.
  void wall(std::uint32_t anchor, std::uint8_t weight = 3, int from = 0) {
    SubmapRecord record{anchor, 20'000, 60'000, {}};
    for (int x = from; x < from + 6; ++x)
      for (int y = 0; y < 6; ++y) {
        record.blocks.push_back({{x, y, 0}, {}});
        for (SubmapVoxel& voxel : record.blocks.back().voxels) voxel = {5, weight, {9, 9, 9}};
      }
    take(author.write(Lane::voxels, RecordKind::submap, record));
  }
  void take(const RecordPtr& record) { EXPECT_TRUE(member.apply(record).ok()); }
  std::vector<std::uint32_t> look() { return needless.look(member, solved); }

  test::Author author{"a"};
  TeamMember member;
  SolvedRobot solved{{RobotId::from_name("a"), 1}, {}};
  std::uint32_t keyframes = 0;
  NeedlessSubmaps needless;
  Walker() { member.incarnation = 1; }
};

TEST(NeedlessSubmaps, WhatWasSeenAgainLaterIsNeedless) {
  Walker walker;
  walker.wall(walker.anchor(0s));
  EXPECT_THAT(walker.look(), IsEmpty());
  walker.wall(walker.anchor(70s));
  EXPECT_THAT(walker.look(), ElementsAre(0));
  EXPECT_THAT(walker.look(), IsEmpty()) << "it is named once";
  walker.wall(walker.anchor(140s));
  EXPECT_THAT(walker.look(), ElementsAre(1));
}

TEST(NeedlessSubmaps, WhatWasSeenInPassingIsOneVisit) {
  Walker walker;
  walker.wall(walker.anchor(0s, 20s));
  walker.wall(walker.anchor(79s));
  EXPECT_THAT(walker.look(), IsEmpty()) << "59 s after it had left";
}

TEST(NeedlessSubmaps, WhatWasSeenWorseOrInPartOrElsewhereIsNot) {
  const auto after = [](std::uint8_t weight, int from, std::int32_t moved_10um) {
    Walker walker;
    walker.wall(walker.anchor(0s), 40);
    walker.wall(walker.anchor(70s), weight, from);
    walker.solved.anchors.back().T_map_anchor.t_10um[0] = moved_10um;
    return walker.look();
  };
  EXPECT_THAT(after(40, 0, 0), ElementsAre(0));
  EXPECT_THAT(after(9, 0, 0), IsEmpty());
  EXPECT_THAT(after(40, 2, 0), IsEmpty());
  EXPECT_THAT(after(40, 0, 100'000), IsEmpty()) << "a metre beside it";
  EXPECT_THAT(after(40, -2, 32'000), ElementsAre(0)) << "two blocks further, and that is where it begins";
}

// Without any solution's help: the submap's own later records have all of it.
TEST(NeedlessSubmaps, WhatWentOutAgainIsNeedlessAtOnce) {
  Walker walker;
  const std::uint32_t anchor = walker.anchor(0s);
  walker.wall(anchor);
  walker.wall(anchor, 9, 3);
  EXPECT_THAT(walker.look(), IsEmpty()) << "half of it";
  walker.wall(anchor, 9, 0);
  EXPECT_THAT(walker.look(), ElementsAre(0));
}

TEST(NeedlessSubmaps, WhatIsNeedlessItselfReplacesNothing) {
  Walker walker;
  walker.wall(walker.anchor(0s));
  walker.wall(walker.anchor(70s), 9);   // better than all that follow
  walker.wall(walker.anchor(140s), 9);  // and again
  EXPECT_THAT(walker.look(), ElementsAre(0, 1));
}

// Else it would need another one to be named, and so on.
TEST(NeedlessSubmaps, ARecordWithoutVoxelsIsLeftAlone) {
  Walker walker;
  walker.wall(walker.anchor(0s));
  walker.take(walker.author.write(Lane::voxels, RecordKind::submap, SubmapRecord{0, 20'000, 60'000, {}}));
  EXPECT_THAT(walker.look(), IsEmpty());
}

TEST(NeedlessSubmaps, AnotherLifeBeginsAnew) {
  Walker walker;
  walker.wall(walker.anchor(0s));
  EXPECT_THAT(walker.look(), IsEmpty());
  Walker next;
  next.member.incarnation = next.solved.chain.incarnation = 2;
  next.wall(next.anchor(70s));
  EXPECT_THAT(walker.needless.look(next.member, next.solved), IsEmpty()) << "what it saw is another log's";
}

}  // namespace
}  // namespace onemap::mapping
