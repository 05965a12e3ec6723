#include "mapping/team/team_member.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using test::Author;
using testing::HasSubstr;

void expect_refused(TeamMember& member, const RecordPtr& record, const char* why) {
  const Status status = member.apply(record);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().text(), HasSubstr(why));
}

TEST(TeamMember, IsCompleteWithWhatItsFinishedPromises) {
  Author author = test::small_robot("a");
  author.finish();
  TeamMember member;
  for (const auto& record : author.written()) {
    EXPECT_FALSE(member.complete());
    ASSERT_TRUE(member.apply(record).ok());
  }
  EXPECT_TRUE(member.complete());
  EXPECT_EQ(member.name, "a");
  EXPECT_EQ(member.keyframes.chain().size(), 3u);
  ASSERT_EQ(member.trajectory.poses().size(), 1u);
  EXPECT_EQ(member.trajectory.poses()[0].time, frame_time_from_ns(1'000'000'000));
}

TEST(TeamMember, MalformedRecordsCountForCompletenessAndNothingElse) {
  const auto number = [](RecordKind kind) { return static_cast<std::uint16_t>(kind); };
  Author author = test::small_robot("a");
  author.write(Lane::features, number(RecordKind::keyframe), {1, 2, 3});
  author.write(Lane::voxels, number(RecordKind::submap), {1, 2, 3});
  author.write(Lane::poses, number(RecordKind::trajectory), {1});
  author.write(Lane::control, RecordKind::finished, FinishedRecord{9, 9, 4, 2});
  TeamMember member;
  std::size_t refused = 0;
  for (const auto& record : author.written()) refused += member.apply(record).ok() ? 0 : 1;
  EXPECT_EQ(refused, 3u);
  EXPECT_EQ(member.keyframes.size(), 4u);
  EXPECT_EQ(member.keyframes.chain().size(), 3u);
  ASSERT_EQ(member.submaps.size(), 2u) << "each has its place";
  EXPECT_EQ(member.submaps.find(1), nullptr);
  EXPECT_TRUE(member.complete());
}

TEST(TeamMember, GreetsOnlyUnderTheNameOfItsLog) {
  Author author("a");
  TeamMember member;
  expect_refused(member, author.write(Lane::control, RecordKind::hello, HelloRecord{"b", "x"}), "not that of the log");
  EXPECT_FALSE(member.counts());
  ASSERT_TRUE(member.apply(author.write(Lane::control, RecordKind::hello, HelloRecord{"a", "caf\xc3\xa9 \xff"})).ok());
  EXPECT_TRUE(member.counts());
  EXPECT_EQ(member.camera, "caf\xc3\xa9 \\xff");
}

// A submap that no decoder takes is refused at its first bytes, and that shows.
TEST(TeamMember, ASubmapWithTooDeepATruncationIsRefused) {
  Author author("a");
  TeamMember member;
  const SubmapRecord deep{0, 10000, 1'010'000, {}};
  expect_refused(member, author.write(Lane::voxels, RecordKind::submap, deep), "truncation_um: not 1 to 100 voxels");
  ASSERT_EQ(member.submaps.size(), 1u);
  EXPECT_EQ(member.submaps.find(0), nullptr);
}

TEST(TeamMember, WritesLinksOfItsOwnPairsOnly) {
  Author a("a"), b("b"), c("c");
  TeamMember of_a, of_b, of_c;
  ASSERT_TRUE(of_a.apply(a.link(test::link_of("a", "b"))).ok());
  ASSERT_TRUE(of_b.apply(b.link(test::link_of("a", "b"))).ok());
  expect_refused(of_c, c.link(test::link_of("a", "b")), "not written by a robot of its pair");
  EXPECT_EQ(of_a.links.size(), 1u);
  EXPECT_EQ(of_b.links.count({a.id(), 1}), 1u);
  EXPECT_TRUE(of_c.links.empty());
}

TEST(TeamMember, OwnLoopsAreOfTwoKeyframesEach) {
  Author a("a", 2);
  TeamMember member;
  LinkRecord loops;
  loops.a = loops.b = a.id();
  loops.incarnation_other = 2;
  loops.pairs = {{3, 3, 60, {}}};
  expect_refused(member, a.link(loops), "not of two keyframes");
  loops.incarnation_other = 1;
  EXPECT_TRUE(member.apply(a.link(loops)).ok()) << "of two lives it may be";
  EXPECT_EQ(member.links.count({a.id(), 1}), 1u);
}

TEST(TeamMember, KeepsABoundedNumberOfKeyframesAndLinks) {
  Author author("a");
  TeamMember member;
  for (std::size_t i = 0; i < KeyframeLog::kMost; ++i) ASSERT_TRUE(member.apply(author.keyframe()).ok());
  expect_refused(member, author.keyframe(), "as many as are looked at");
  EXPECT_EQ(member.keyframes.size(), KeyframeLog::kMost);
  EXPECT_EQ(member.keyframes.chain().size(), KeyframeLog::kMost);
  ASSERT_TRUE(member.apply(author.finish()).ok());
  EXPECT_TRUE(member.keyframes_complete()) << "what is refused is not waited for";
  for (std::size_t i = 0; i < TeamMember::kMaxLinks; ++i)
    ASSERT_TRUE(member.apply(author.link(test::link_of("a", fmt::format("b{}", i)))).ok());
  expect_refused(member, author.link(test::link_of("a", "one-more")), "links to as many");
  EXPECT_TRUE(member.apply(author.link(test::link_of("a", "b0"))).ok()) << "a known pair may be looked at again";
  EXPECT_EQ(member.links.size(), TeamMember::kMaxLinks);
}

}  // namespace
}  // namespace onemap::mapping
