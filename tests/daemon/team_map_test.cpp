// The team's map as a function of records: no threads, no sockets; what a robot publishes is put into its log by hand.
#include "daemon/team_map.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/kind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <set>

#include "daemon/cameras.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/random.hpp"

namespace onemap::daemon {
namespace {

using mapping::Lane;
using mapping::RecordKind;
using RecordPtr = std::shared_ptr<const Record>;
using Records = std::vector<RecordPtr>;

constexpr Instant kNow{};

// What one robot writes: each lane is one log.
class Author {
 public:
  explicit Author(const std::string& name, std::uint64_t incarnation = 1)
      : id_(RobotId::from_name(name)), incarnation_(incarnation) {}

  RecordPtr write(Lane lane, std::uint16_t kind, std::vector<std::uint8_t> body) {
    const auto number = static_cast<std::uint8_t>(lane);
    Record record{{{id_, number, incarnation_}, next_[number]++}, kind, std::move(body)};
    written_.push_back(std::make_shared<const Record>(std::move(record)));
    return written_.back();
  }
  template <class Body>
  RecordPtr write(Lane lane, RecordKind kind, const Body& body) {
    return write(lane, static_cast<std::uint16_t>(kind), encode(body));
  }
  const Records& written() const { return written_; }
  RobotId id() const { return id_; }

 private:
  RobotId id_;
  std::uint64_t incarnation_;
  std::map<std::uint8_t, std::uint32_t> next_;
  Records written_;
};

// A robot's whole mapping of a simulated camera, as records.
Author explore(const std::string& name, const std::string& camera_text, std::uint64_t incarnation = 1) {
  Author author(name, incarnation);
  auto camera = std::move(hal::open_camera(camera_backends(), camera_text).value());
  hal::FramePool pool(camera->intrinsics(), 2);
  mapping::LocalMapperConfig config;
  config.max_keyframes = 60;
  config.map.budget_bytes = 16u << 20;
  mapping::LocalMapper mapper(config, camera->intrinsics());
  author.write(Lane::control, RecordKind::hello, mapping::HelloRecord{name, camera_text});
  mapping::FinishedRecord finished;
  for (; camera; ++finished.frames) {
    hal::Frame frame = pool.acquire();
    if (camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    mapper.process(frame.view());
  }
  mapper.finish();
  mapping::KeyframeRecord keyframe;
  for (; mapper.take_keyframe(keyframe); ++finished.keyframes)
    author.write(Lane::features, RecordKind::keyframe, keyframe);
  for (mapping::TrajectoryRecord poses; mapper.take_poses(poses);) {
    finished.tracked += static_cast<std::uint32_t>(poses.poses.size());
    author.write(Lane::poses, RecordKind::trajectory, poses);
  }
  for (auto blocks = mapper.map().take_settled(0, 100); !blocks.empty(); blocks = mapper.map().take_settled(0, 100)) {
    author.write(Lane::voxels, RecordKind::submap, mapping::make_submap(mapper.map(), blocks));
    ++finished.submaps;
  }
  author.write(Lane::control, RecordKind::finished, finished);
  return author;
}

const Author& first() {
  static const Author author = explore("robot1", "simulated:living-room?robot=1&robots=3&frames=60&seed=3");
  return author;
}
const Author& second() {
  static const Author author = explore("robot2", "simulated:living-room?robot=2&robots=3&frames=60&seed=3");
  return author;
}
const Author& stranger() {
  static const Author author = explore("robot3", "simulated:storage?robot=1&robots=3&frames=40&seed=3");
  return author;
}

// One robot of the team with nothing but its TeamMap; what it publishes goes into its log and back to it.
class Robot {
 public:
  // The mapping that this robot did itself is taken over, so that what it publishes continues the logs.
  explicit Robot(Author author, Duration merge_while_mapping = Duration::zero())
      : author_(std::move(author)), log_(author_.id().name()) {
    TeamMapConfig config;
    config.atlas.map.budget_bytes = 32u << 20;
    config.merge_while_mapping = merge_while_mapping;
    map_.emplace(
        author_.id(), config, [this](OutgoingRecord record) { outbox_.push_back(std::move(record)); }, log_);
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void apply(const RecordPtr& record) {
    held_.push_back(record);
    map_->apply(record, kNow);
  }
  void apply(const Records& records) {
    for (const RecordPtr& record : records) apply(record);
  }
  // Works until nothing is left to do; returns what it published.
  Records work(Instant now = kNow) {
    Records published;
    for (;;) {
      const bool busy = map_->step(now);
      map_->observe(now);
      if (!busy && outbox_.empty()) return published;
      for (OutgoingRecord& record : std::exchange(outbox_, {})) {
        published.push_back(author_.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body));
        apply(published.back());
      }
    }
  }
  const Records& held() const { return held_; }
  const TeamMap& map() const { return *map_; }
  TeamView view() const { return map_->view(); }

 private:
  Author author_;
  Log log_;
  std::vector<OutgoingRecord> outbox_;
  Records held_;
  std::optional<TeamMap> map_;
};

// All records of a team of one decider (robot1) and the others, once robot1 and robot2 have verified and solved.
Records whole_team(const std::vector<const Author*>& authors) {
  std::deque<Robot> robots;
  Records all;
  for (const Author* author : authors) {
    robots.emplace_back(*author);
    all.insert(all.end(), author->written().begin(), author->written().end());
  }
  for (Robot& robot : robots) robot.apply(all);
  for (bool news = true; news;) {
    news = false;
    for (Robot& robot : robots)
      for (const RecordPtr& record : robot.work()) {
        news = true;
        all.push_back(record);
        for (Robot& other : robots)
          if (&other != &robot) other.apply(record);
      }
  }
  return all;
}

// The records in a random order that keeps each log's.
Records shuffled(const Records& records, std::uint64_t seed) {
  std::map<LogId, std::deque<RecordPtr>> logs;
  for (const RecordPtr& record : records) logs[record->id.log].push_back(record);
  test::Random random(seed);
  Records out;
  while (!logs.empty()) {
    auto log = logs.begin();
    std::advance(log, random.integer(0, static_cast<std::int64_t>(logs.size()) - 1));
    out.push_back(log->second.front());
    log->second.pop_front();
    if (log->second.empty()) logs.erase(log);
  }
  return out;
}

// A robot that only listens: nobody's pair, never elected.
Author listener() { return Author("zz-listener"); }

std::vector<std::vector<std::uint8_t>> links_of(const Robot& robot) {
  std::vector<std::vector<std::uint8_t>> out;
  for (const auto& link : robot.map().links()) out.push_back(encode(link));
  return out;
}

TEST(TeamMap, OrderOfArrivalDoesNotMatter) {
  const Records all = whole_team({&first(), &second(), &stranger()});
  Robot in_order(listener());
  in_order.apply(all);
  EXPECT_TRUE(in_order.work().empty());
  ASSERT_TRUE(in_order.view().settled);
  ASSERT_NE(in_order.view().digest, 0u);
  EXPECT_EQ(in_order.map().links().size(), 3u);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Robot robot(listener());
    for (const RecordPtr& record : shuffled(all, seed)) {
      robot.apply(record);
      if (seed % 2 == 0) robot.work();  // whether it works in between or only at the end
    }
    robot.work();
    EXPECT_TRUE(robot.view().settled);
    EXPECT_EQ(robot.view().digest, in_order.view().digest);
    EXPECT_EQ(links_of(robot), links_of(in_order));
  }
}

TEST(TeamMap, ARobotWithoutLinksStaysOutAndIsStillListed) {
  Robot robot(listener());
  robot.apply(whole_team({&first(), &second(), &stranger()}));
  robot.work();
  EXPECT_EQ(robot.view().robots_known, 3u);
  EXPECT_EQ(robot.view().robots_finished, 3u);
  EXPECT_EQ(robot.view().robots_in_map, 2u);
  EXPECT_EQ(robot.map().members().at(stranger().id()).name, "robot3");
  EXPECT_FALSE(robot.map().members().at(stranger().id()).poses.empty());
  const auto solution = robot.map().solution();
  ASSERT_TRUE(solution.has_value());
  for (const auto& solved : solution->robots) EXPECT_NE(solved.robot, stranger().id());
  for (const auto& link : robot.map().links())
    EXPECT_EQ(link.reason == mapping::LinkReason::accepted, link.b == second().id()) << link.b.name();
}

TEST(TeamMap, RobotsThatKnewDifferentPartsAgreeOnceTheyHoldTheSame) {
  const Records all = whole_team({&first(), &second(), &stranger()});
  Robot a(listener()), b(listener());
  Records left_for_a, left_for_b;
  std::set<LogId> cut_a, cut_b;  // a log is held up to a record
  for (std::size_t i = 0; i < all.size(); ++i) {
    const LogId& log = all[i]->id.log;
    if (i % 7 == 3) cut_a.insert(log);
    if (i % 5 == 2) cut_b.insert(log);
    cut_a.contains(log) ? left_for_a.push_back(all[i]) : a.apply(all[i]);
    cut_b.contains(log) ? left_for_b.push_back(all[i]) : b.apply(all[i]);
  }
  a.work();
  b.work();
  EXPECT_FALSE(a.view().settled);
  EXPECT_FALSE(b.view().settled);
  a.apply(left_for_a);
  b.apply(shuffled(left_for_b, 5));
  a.work();
  b.work();
  EXPECT_TRUE(a.view().settled);
  EXPECT_TRUE(b.view().settled);
  EXPECT_EQ(a.view().digest, b.view().digest);
  EXPECT_NE(a.view().digest, 0u);
}

TEST(TeamMap, ANewerLifeReplacesTheEarlier) {
  const Author reborn = explore("robot2", "simulated:living-room?robot=3&robots=3&frames=60&seed=3", 2);
  Robot expected(listener());
  expected.apply(whole_team({&first(), &reborn}));
  expected.work();
  ASSERT_EQ(expected.view().robots_in_map, 2u);

  // robot1 lives through both lives of robot2; another hears both in any order.
  Robot robot1(first());
  robot1.apply(first().written());
  robot1.apply(second().written());
  robot1.work();
  const std::uint64_t before = robot1.view().digest;
  EXPECT_TRUE(robot1.view().settled);
  robot1.apply(reborn.written());
  EXPECT_FALSE(robot1.view().settled);
  robot1.work();
  EXPECT_TRUE(robot1.view().settled);
  EXPECT_NE(robot1.view().digest, before);
  EXPECT_EQ(robot1.view().digest, expected.view().digest);
  EXPECT_EQ(robot1.map().members().at(reborn.id()).incarnation, 2u);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Robot robot(listener());
    robot.apply(shuffled(robot1.held(), seed));
    robot.work();
    EXPECT_TRUE(robot.view().settled);
    EXPECT_EQ(robot.view().digest, expected.view().digest);
  }
}

TEST(TeamMap, MalformedRecordsAreCountedAndLoseNothingElse) {
  const auto number = [](RecordKind kind) { return static_cast<std::uint16_t>(kind); };
  Author odd("robot2");
  for (const RecordPtr& record : second().written()) {
    const auto lane = static_cast<Lane>(record->id.log.lane);
    auto body = record->body;
    if (record->kind == number(RecordKind::finished)) {
      auto finished = mapping::decode_finished(body).value();
      odd.write(Lane::features, number(RecordKind::keyframe), {1, 2, 3});
      odd.write(Lane::voxels, number(RecordKind::submap), std::vector<std::uint8_t>(40, 7));
      odd.write(Lane::poses, number(RecordKind::link), {0});
      odd.write(Lane::poses, number(RecordKind::solution), {9, 9});
      odd.write(Lane::poses, 999, {1});
      ++finished.keyframes;
      ++finished.submaps;
      body = encode(finished);
    }
    odd.write(lane, record->kind, body);
  }
  Robot plain(listener()), robot(listener());
  plain.apply(whole_team({&first(), &second()}));
  robot.apply(whole_team({&first(), &odd}));
  plain.work();
  robot.work();
  ASSERT_TRUE(plain.view().settled);
  EXPECT_TRUE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, plain.view().digest);
  EXPECT_TRUE(plain.map().refused().empty());
  const auto& refused = robot.map().refused();
  EXPECT_EQ(refused.size(), 5u);
  for (const auto& [kind, what] : refused) EXPECT_EQ(what.count, 1u) << kind << ": " << what.last_reason;
  EXPECT_THAT(refused.at(number(RecordKind::keyframe)).last_reason, testing::HasSubstr("keyframe"));
  EXPECT_THAT(refused.at(number(RecordKind::submap)).last_reason, testing::HasSubstr("voxel_um"));
  EXPECT_THAT(refused.at(999).last_reason, testing::HasSubstr("not known"));
}

TEST(TeamMap, AskedToStopItDoesNothingByHalves) {
  TeamMapConfig config;
  std::vector<OutgoingRecord> published;
  Log log("robot1");
  TeamMap map(
      first().id(), config, [&](OutgoingRecord record) { published.push_back(std::move(record)); }, log);
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) map.apply(record, kNow);
  int asked = 0;
  EXPECT_FALSE(map.step(kNow, [&] { return ++asked > 3; }));
  EXPECT_EQ(asked, 4);
  EXPECT_TRUE(published.empty());
  EXPECT_TRUE(map.step(kNow));  // and the pair is verified as if nothing had been
  ASSERT_EQ(published.size(), 1u);
  EXPECT_EQ(published[0].kind, RecordKind::link);
}

TEST(TeamMap, MergesWhileRobotsMapAndEndsWithTheSameMap) {
  const Records all = whole_team({&first(), &second()});
  Robot expected(listener());
  expected.apply(all);
  expected.work();

  const auto finished = [](const RecordPtr& r) { return r->kind == static_cast<std::uint16_t>(RecordKind::finished); };
  Robot robot1(first(), std::chrono::seconds(10));
  Records last;
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) finished(record) ? last.push_back(record) : robot1.apply(record);
  Instant now = kNow + std::chrono::seconds(100);
  EXPECT_FALSE(robot1.work(now).empty());
  EXPECT_EQ(robot1.view().robots_finished, 0u);
  EXPECT_EQ(robot1.view().robots_in_map, 2u);
  EXPECT_NE(robot1.view().digest, 0u);
  EXPECT_FALSE(robot1.view().settled);
  EXPECT_TRUE(robot1.work(now + std::chrono::seconds(60)).empty()) << "nothing new, nothing done";
  robot1.apply(last);
  robot1.work(now);
  EXPECT_TRUE(robot1.view().settled);
  EXPECT_EQ(robot1.view().digest, expected.view().digest);
}

}  // namespace
}  // namespace onemap::daemon
