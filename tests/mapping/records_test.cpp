#include "mapping/records/finished.hpp"
#include "mapping/records/frontier.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/ruling.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "random_records.hpp"
#include "support/voxel_error.hpp"

namespace onemap::mapping {
namespace {

using test::Random;
using namespace random_records;
using Bytes = std::vector<std::uint8_t>;

struct Codec {
  const char* kind;
  Bytes (*sample)(Random&);
  // The body encoded again, or nothing when it was refused; reason gets the error's text.
  std::optional<Bytes> (*again)(std::span<const std::uint8_t>, std::string& reason);
};

template <auto kMake>
Bytes sample(Random& random) {
  return encode(kMake(random));
}
template <auto kDecode>
std::optional<Bytes> again(std::span<const std::uint8_t> body, std::string& reason) {
  const auto record = kDecode(body);
  if (record.ok()) return encode(*record);
  reason = record.error().text();
  return std::nullopt;
}

const Codec kCodecs[] = {
    {"hello", sample<random_hello>, again<decode_hello>},
    {"keyframe", sample<random_keyframe>, again<decode_keyframe>},
    {"trajectory", sample<random_trajectory>, again<decode_trajectory>},
    {"submap", sample<random_submap>, again<decode_submap>},
    {"link", sample<random_link>, again<decode_link>},
    {"solution", sample<random_solution>, again<decode_solution>},
    {"frontier", sample<random_frontier>, again<decode_frontier>},
    {"ruling", sample<random_ruling>, again<decode_ruling>},
    {"finished", sample<random_finished>, again<decode_finished>},
};

class RecordCodec : public testing::TestWithParam<Codec> {};
INSTANTIATE_TEST_SUITE_P(All, RecordCodec, testing::ValuesIn(kCodecs),
                         [](const auto& codec) { return codec.param.kind; });

TEST_P(RecordCodec, EncodesWhatItDecoded) {
  Random random(11);
  std::string reason;
  for (int i = 0; i < 100; ++i) {
    const Bytes body = GetParam().sample(random);
    EXPECT_EQ(GetParam().again(body, reason), body) << reason;
  }
}

TEST_P(RecordCodec, RefusesEveryTruncationAndWhatFollows) {
  Random random(12);
  std::string reason;
  Bytes body = GetParam().sample(random);
  for (std::size_t size = 0; size < body.size(); ++size) {
    EXPECT_FALSE(GetParam().again(std::span(body).first(size), reason)) << size;
    EXPECT_THAT(reason, testing::StartsWith(std::string(GetParam().kind) + " record, "));
  }
  body.push_back(0);
  EXPECT_FALSE(GetParam().again(body, reason));
}

// Random damage is refused or gives a record whose encoding is stable and (but for zstd's freedom) the very bytes.
TEST_P(RecordCodec, NeverAcceptsWhatIsNotCanonical) {
  Random random(13);
  std::string reason;
  const bool compressed =
      std::string_view(GetParam().kind) == "submap" || std::string_view(GetParam().kind) == "keyframe";
  for (int i = 0; i < 4000; ++i) {
    Bytes body = GetParam().sample(random);
    for (auto flips = random.integer(1, 4); flips > 0; --flips)
      body[static_cast<std::size_t>(random.next() % body.size())] ^=
          static_cast<std::uint8_t>(1u << random.integer(0, 7));
    const auto out = GetParam().again(body, reason);
    if (!out) continue;
    if (!compressed) {
      EXPECT_EQ(*out, body);
    }
    EXPECT_EQ(GetParam().again(*out, reason), *out);
  }
}

TEST_P(RecordCodec, RefusesNoise) {
  Random random(14);
  std::string reason;
  for (int i = 0; i < 2000; ++i) {
    Bytes body(static_cast<std::size_t>(random.integer(0, 300)));
    for (auto& byte : body) byte = static_cast<std::uint8_t>(random.next());
    const auto out = GetParam().again(body, reason);
    if (out) {
      EXPECT_EQ(*out, body);
    }
  }
}

TEST(Records, DecodeGivesEveryFieldBack) {
  Random random(5);
  const KeyframeRecord keyframe = random_keyframe(random);
  const auto k = decode_keyframe(encode(keyframe));
  ASSERT_TRUE(k.ok());
  EXPECT_EQ(k->index, keyframe.index);
  EXPECT_EQ(k->time, keyframe.time);
  EXPECT_EQ(k->T_robot_keyframe, keyframe.T_robot_keyframe);
  ASSERT_EQ(k->features.size(), keyframe.features.size());
  for (std::size_t i = 0; i < k->features.size(); ++i) {
    EXPECT_EQ(k->features[i].place, keyframe.features[i].place);
    EXPECT_EQ(k->features[i].laplacian, keyframe.features[i].laplacian);
    EXPECT_EQ(k->features[i].bits, keyframe.features[i].bits);
  }
  EXPECT_EQ(k->grid.inverse_depth, keyframe.grid.inverse_depth);

  SubmapRecord submap;
  while (submap.blocks.size() < 3) submap = random_submap(random);
  const auto s = decode_submap(encode(submap));
  ASSERT_TRUE(s.ok()) << s.error().text();
  EXPECT_EQ(s->anchor_keyframe, submap.anchor_keyframe);
  ASSERT_EQ(s->blocks.size(), submap.blocks.size());
  for (std::size_t b = 0; b < s->blocks.size(); ++b) {
    EXPECT_EQ(s->blocks[b].key, submap.blocks[b].key);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const SubmapVoxel &got = s->blocks[b].voxels[i], &put = submap.blocks[b].voxels[i];
      ASSERT_TRUE(test::within_half_a_step(got, put))
          << got.tsdf << " " << int{got.weight} << " " << int{got.rgb[0]} << " " << int{got.rgb[1]} << " "
          << int{got.rgb[2]} << " for " << put.tsdf << " " << int{put.weight} << " " << int{put.rgb[0]} << " "
          << int{put.rgb[1]} << " " << int{put.rgb[2]};
    }
  }
}

template <class T>
void expect_refused(const Result<T>& result, const char* field) {
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().text(), testing::HasSubstr(field));
}

TEST(Records, NamesTheFieldThatBreaksABound) {
  Random random(6);
  expect_refused(decode_hello(encode(HelloRecord{"a b", ""})), "name");
  expect_refused(decode_hello(encode(HelloRecord{"a", "x\x1b[31m"})), "camera");
  expect_refused(decode_hello(encode(HelloRecord{"a", "", 0, (1 << 24) + 1})), "map blocks");
  LinkRecord link = random_link(random);
  std::swap(link.a, link.b);
  expect_refused(decode_link(encode(link)), "record, b");
  link = random_link(random);
  link.T_a_b.q_wxyz = {1 << 30, 1 << 30, 0, 0};
  expect_refused(decode_link(encode(link)), "T_a_b");
  TrajectoryRecord trajectory;
  trajectory.poses.resize(2);
  expect_refused(decode_trajectory(encode(trajectory)), "poses.time");
  trajectory.poses.resize(4097);
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i)
    trajectory.poses[i].time = frame_time_from_ns(static_cast<std::int64_t>(i));
  expect_refused(decode_trajectory(encode(trajectory)), "poses");
  SolutionRecord solution = random_solution(random);
  solution.reference = {RobotId::from_name("stranger"), 1};
  expect_refused(decode_solution(encode(solution)), "reference");
  solution = random_solution(random);
  solution.map.voxel_um = 999;
  expect_refused(decode_solution(encode(solution)), "map.voxel_um");
  solution.map = {20'000, 19'999, 5};
  expect_refused(decode_solution(encode(solution)), "map.truncation_um");
  solution.map = {20'000, 60'000, 0};
  expect_refused(decode_solution(encode(solution)), "map.blocks");
  solution = random_solution(random);
  solution.up = {{0, 900'000, 0}};
  expect_refused(decode_solution(encode(solution)), "up: not of unit length");
  FrontierRecord frontier{1, {{{RobotId::from_name("a"), 2}, 1, 1}, {{RobotId::from_name("a"), 1}, 1, 1}}};
  expect_refused(decode_frontier(encode(frontier)), "chains: not sorted");
  SubmapRecord submap;
  while (submap.blocks.size() < 2) submap = random_submap(random);
  std::swap(submap.blocks[0], submap.blocks[1]);
  expect_refused(decode_submap(encode(submap)), "blocks.key");
  submap.blocks[0].key = submap.blocks[1].key;
  expect_refused(decode_submap(encode(submap)), "blocks.key");
  submap.blocks.resize(1);
  submap.blocks[0].voxels[9] = {2 * kTsdfOne, 1, {}};
  expect_refused(decode_submap(encode(submap)), "blocks.voxels");
  submap.blocks.clear();
  submap.truncation_um = 1;
  expect_refused(decode_submap(encode(submap)), "truncation_um");
  submap.truncation_um = 101 * submap.voxel_um;
  expect_refused(decode_submap(encode(submap)), "truncation_um");
}

TEST(Records, RefuseRobotsThatHaveNoValidName) {
  Random random(7);
  for (const std::string name : {"../../PWNED", "a/b", "..", "!\xff\x1b[31m\n", "x y", ""}) {
    LinkRecord link = random_link(random);
    link.b = RobotId::from_name(name);
    link.a = RobotId::from_name("\x01");
    expect_refused(decode_link(encode(link)), "record, a: no robot's name");
    link.a = RobotId::from_name("-");
    if (link.a < link.b) expect_refused(decode_link(encode(link)), "record, b: no robot's name");
    SolutionRecord solution = random_solution(random);
    solution.reference = {RobotId::from_name(name), 1};
    expect_refused(decode_solution(encode(solution)), "reference: no robot's name");
    solution = random_solution(random);
    solution.robots.insert(solution.robots.begin(), SolvedRobot{{RobotId::from_name(name), 0}, {}});
    expect_refused(decode_solution(encode(solution)), "robots.chain: no robot's name");
  }
  LinkRecord hidden = random_link(random);
  hidden.b.bytes[15] = 'x';  // behind the zero that ends the name
  expect_refused(decode_link(encode(hidden)), "record, b: no robot's name");
}

TEST(Records, LinksClaimNoMoreThanTheirPairsCanHave) {
  Random random(8);
  LinkRecord link = random_link(random);
  link.reason = LinkReason::accepted;
  link.measured = 0;
  link.supporting_pairs = 2;
  link.inliers = 2000;
  EXPECT_TRUE(decode_link(encode(link)).ok());
  link.inliers = 2001;
  expect_refused(decode_link(encode(link)), "inliers");
  link.supporting_pairs = 1025;
  expect_refused(decode_link(encode(link)), "supporting_pairs");
}

TEST(Records, ASolutionsAnchorsAndReferenceAreInOrder) {
  SolutionRecord solution;
  solution.reference = {RobotId::from_name("a"), 1};
  solution.robots.push_back({solution.reference, {{0, {}}, {4, {}}}});
  EXPECT_TRUE(decode_solution(encode(solution)).ok());
  solution.robots[0].anchors[1].keyframe = 0;
  expect_refused(decode_solution(encode(solution)), "robots.anchors");
  solution.robots[0].anchors.clear();
  EXPECT_TRUE(decode_solution(encode(solution)).ok());
  solution.reference = {RobotId::from_name("a"), 2};
  expect_refused(decode_solution(encode(solution)), "not among the robots");
}

TEST(Records, ALinksPairsAreInOrderAndOfTheRobotsThatItJoins) {
  LinkRecord link;
  link.a = RobotId::from_name("a");
  link.b = RobotId::from_name("b");
  link.pairs = {{3, 1, 60, {}}, {3, 2, 60, {}}};
  EXPECT_TRUE(decode_link(encode(link)).ok());
  const auto refused = [&](auto change, const char* why) {
    LinkRecord changed = link;
    change(changed);
    expect_refused(decode_link(encode(changed)), why);
  };
  refused([](LinkRecord& l) { l.pairs[1].keyframe_b = 1; }, "not sorted");
  refused([](LinkRecord& l) { l.pairs[0].inliers = 0; }, "pairs.inliers");
  refused([](LinkRecord& l) { l.pairs[0].inliers = 1001; }, "pairs.inliers");
  refused([](LinkRecord& l) { l.reason = LinkReason::icp_failed; }, "of a link that is refused");
  refused([](LinkRecord& l) { l.pairs.assign(257, l.pairs[0]); }, "more than allowed");
  refused([](LinkRecord& l) { l.measured = 7; }, "of a link that is accepted");
  link.b = link.a;
  link.pairs = {{1, 3, 60, {}}};
  EXPECT_TRUE(decode_link(encode(link)).ok()) << "one robot's own loop";
  EXPECT_TRUE(check_own_loops(link).ok());
  LinkRecord changed = link;
  changed.pairs[0].keyframe_b = 1;
  EXPECT_THAT(check_own_loops(changed).error().text(), testing::HasSubstr("not of two keyframes"));
  EXPECT_TRUE(decode_link(encode(changed)).ok()) << "of two lives it may be";
  changed = link;
  changed.T_a_b.t_10um[0] = 1;
  EXPECT_THAT(check_own_loops(changed).error().text(), testing::HasSubstr("not the identity"));
}

// What a submap will cost is known from its first bytes, and a lie about it is refused before anything is taken.
TEST(Records, ASubmapsHeaderTellsWhatDecodingCosts) {
  Random random(9);
  SubmapRecord submap;
  while (submap.blocks.size() < 3) submap = random_submap(random);
  Bytes body = encode(submap);
  const auto header = decode_submap_header(body);
  ASSERT_TRUE(header.ok()) << header.error().text();
  EXPECT_EQ(header->blocks, submap.blocks.size());
  EXPECT_EQ(header->voxel_um, submap.voxel_um);
  EXPECT_GE(header->content_bytes, submap.blocks.size() * 76);
  body[12] = 1;  // fewer blocks than the content is for
  expect_refused(decode_submap_header(body), "more content than the blocks can need");
  expect_refused(decode_submap(body), "more content than the blocks can need");
  body[12] = 200;
  expect_refused(decode_submap_header(body), "more than the content holds");
  body.pop_back();
  expect_refused(decode_submap_header(body), "blocks");
}

}  // namespace
}  // namespace onemap::mapping
