// Two groups of robots that never heard of each other, each with its own map, meet.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using test::kNow;
using test::link_of;
using test::Records;
using test::Robot;
using Group = std::vector<Robot*>;

std::size_t solutions_of(const Records& records, const Robot& robot) {
  return static_cast<std::size_t>(std::ranges::count_if(records, [&](const RecordPtr& record) {
    return record->kind == static_cast<std::uint16_t>(RecordKind::solution) && record->id.log.robot == robot.id();
  }));
}

// So many seconds in which everybody hears everybody; what was published.
Records together(const Group& group, Instant from, int seconds) {
  Records all;
  for (int s = 0; s < seconds; ++s)
    for (Robot* robot : group)
      for (const RecordPtr& record : robot->work(from + std::chrono::seconds(s))) {
        all.push_back(record);
        for (Robot* other : group)
          if (other != robot) other->apply(record, from + std::chrono::seconds(s));
      }
  return all;
}

void tell(const Group& group, const Records& records) {
  for (Robot* robot : group) robot->apply(records);
}

// a and b are linked, and c and d, these by more; each group has its map, and still maps.
struct TeamPartitions : testing::Test {
  TeamPartitions() {
    for (std::size_t i = 0; i < 4; ++i) {
      authors[i].submap({static_cast<int>(i), 7, 7}, static_cast<std::uint8_t>(50 + i));
      if (i == 0) authors[i].link(link_of("a", "b", 100));
      if (i == 2) authors[i].link(link_of("c", "d", 900));
      robots.emplace_back(authors[i], 10s);
    }
    for (const Group& group : {ab(), cd()}) {
      for (Robot* robot : group) tell(group, authors[static_cast<std::size_t>(robot->id().name()[0] - 'a')].written());
      together(group, kNow + 1s, 15);
    }
  }
  Group ab() { return {&robots[0], &robots[1]}; }
  Group cd() { return {&robots[2], &robots[3]}; }
  Group all() { return {&robots[0], &robots[1], &robots[2], &robots[3]}; }
  Records meet(int seconds) {
    const Records of_ab = robots[0].held(), of_cd = robots[2].held();
    tell(cd(), of_ab);
    tell(ab(), of_cd);
    return together(all(), kNow + 60s, seconds);
  }
  std::vector<Author> authors{test::small_robot("a"), test::small_robot("b"), test::small_robot("c"),
                              test::small_robot("d")};
  std::deque<Robot> robots;
};

TEST_F(TeamPartitions, ThatMeetSettleOnOneSolution) {
  ASSERT_NE(robots[0].view().digest, 0u);
  ASSERT_NE(robots[2].view().digest, 0u);
  ASSERT_EQ(robots[0].view().digest, robots[1].view().digest);
  ASSERT_EQ(robots[2].view().digest, robots[3].view().digest);
  ASSERT_NE(robots[0].view().digest, robots[2].view().digest);
  const ChainId of_ab = robots[0].map().solution()->reference, of_cd = robots[2].map().solution()->reference;
  ASSERT_NE(of_ab, of_cd);

  tell(cd(), {robots[1].say(link_of("b", "c", 100))});
  tell({&robots[0]}, {robots[1].held().back()});
  const Records said = meet(30);
  EXPECT_GE(solutions_of(said, robots[0]), 1u) << "the lowest id of the one group that there is now";
  EXPECT_EQ(solutions_of(said, robots[2]), 0u) << "who decided for its group does not any longer";
  const SolutionRecord& solution = *robots[0].map().solution();
  EXPECT_EQ(solution.robots.size(), 4u);
  for (const Robot& robot : robots) {
    EXPECT_EQ(robot.view().digest, robots[0].view().digest) << robot.id().name();
    ASSERT_NE(robot.map().solution(), nullptr) << robot.id().name();
    EXPECT_EQ(encode(*robot.map().solution()), encode(solution)) << robot.id().name();
    EXPECT_TRUE(robot.view().T_map_odometry.has_value()) << robot.id().name();
  }
  EXPECT_EQ(solution.reference, of_ab) << "the frame of who decides stays";
  EXPECT_TRUE(together(all(), kNow + 100s, 3).empty()) << "and that is all";
}

// Nothing joins them: the largest group's lowest id decides, of equal groups the one with the lowest id, and nobody of
// the other group waits for a place.
TEST_F(TeamPartitions, ThatNothingJoinsHaveTheFirstGroupsMap) {
  meet(30);
  const SolutionRecord& solution = *robots[0].map().solution();
  for (const Robot& robot : robots) {
    EXPECT_EQ(robot.view().digest, robots[0].view().digest) << robot.id().name();
    EXPECT_EQ(encode(*robot.map().solution()), encode(solution)) << robot.id().name();
  }
  EXPECT_EQ(solution.robots.size(), 2u);
  EXPECT_TRUE(together(all(), kNow + 100s, 3).empty());
}

}  // namespace
}  // namespace onemap::mapping
