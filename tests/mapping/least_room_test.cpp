// Robots of unlike budgets in one team: what one of them has no room for is in nobody's map.
#include <gtest/gtest.h>

#include "support/team_robots.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using test::Records;
using test::Robot;

AtlasConfig with_room(std::size_t megabytes) {
  AtlasConfig out;
  out.map.budget_bytes = megabytes << 20;
  return out;
}

Author greeting(const std::string& name, const AtlasConfig& config) {
  Author out(name);
  HelloRecord hello{name, "test"};
  hello.map_blocks = map_parameters(config).blocks;
  out.write(Lane::control, RecordKind::hello, hello);
  return out;
}

TEST(LeastRoom, OfTheTeamIsEverybodysMap) {
  const AtlasConfig plenty = with_room(32), little = with_room(5);
  Author large = greeting("large", plenty), small = greeting("small", little);
  for (Author* author : {&large, &small}) author->write(Lane::control, RecordKind::finished, FinishedRecord{});
  Robot a(large, Duration::zero(), plenty), b(small, Duration::zero(), little);
  Robot all_of_it(test::first(), Duration::zero(), plenty);
  for (const Author* author : {&test::first(), &test::second()}) {
    all_of_it.apply(author->written());
    for (Robot* robot : {&a, &b}) robot->apply(author->written());
  }
  for (Robot* robot : {&a, &b, &all_of_it})
    for (const Author* author : {&large, &small}) robot->apply(author->written());
  const Records links = all_of_it.work();
  for (Robot* robot : {&a, &b}) robot->apply(links);
  for (int round = 0; round < 3; ++round) {
    b.apply(a.work());
    a.apply(b.work());
  }
  for (Robot* robot : {&a, &b}) ASSERT_TRUE(robot->view().settled);
  ASSERT_NE(a.map().solution(), nullptr);
  EXPECT_EQ(a.map().solution()->map.blocks, map_parameters(little).blocks);
  EXPECT_GT(a.view().blocks_refused, 0u) << "the house must be too large for the small one";
  EXPECT_EQ(a.view().digest, b.view().digest);
  EXPECT_EQ(a.view().blocks_refused, b.view().blocks_refused);
}

TEST(LeastRoom, ThatIsAbsurdCountsAsTwoMegabytes) {
  Author liar("z");
  liar.write(Lane::control, RecordKind::hello, HelloRecord{"z", "test", 0, 1});
  liar.write(Lane::control, RecordKind::finished, FinishedRecord{});
  Robot robot(test::first(), Duration::zero(), with_room(32));
  robot.apply(test::first().written());
  robot.apply(liar.written());
  robot.work();
  ASSERT_NE(robot.map().solution(), nullptr);
  EXPECT_EQ(robot.map().solution()->map.blocks, 512u);
}

}  // namespace
}  // namespace onemap::mapping
