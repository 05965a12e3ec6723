// The team's map as a function of records: no threads, no sockets; what a robot publishes is put into its log by hand.
#include "mapping/team/team_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <set>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/team/reference.hpp"
#include "support/random.hpp"
#include "support/team_author.hpp"

namespace onemap::mapping {
namespace {

using namespace std::chrono_literals;
using test::Author;
using Records = std::vector<RecordPtr>;

constexpr Instant kNow{};
constexpr Duration kLostAfter = 60s;

// A robot's whole mapping of a simulated camera, as records.
Author explore(const std::string& name, const std::string& camera_text, std::uint64_t incarnation = 1) {
  Author author(name, incarnation);
  auto camera = std::move(hal::open_simulated(*hal::parse_camera_address(camera_text)).value());
  hal::FramePool pool(camera->intrinsics(), 2);
  LocalMapperConfig config;
  config.max_keyframes = 60;
  config.map.budget_bytes = 16u << 20;
  LocalMapper mapper(config, camera->intrinsics());
  author.write(Lane::control, RecordKind::hello, HelloRecord{name, camera_text});
  FinishedRecord finished;
  for (; camera; ++finished.frames) {
    hal::Frame frame = pool.acquire();
    if (camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    mapper.process(frame.view());
  }
  mapper.finish();
  KeyframeRecord keyframe;
  for (; mapper.take_keyframe(keyframe); ++finished.keyframes)
    author.write(Lane::features, RecordKind::keyframe, keyframe);
  for (TrajectoryRecord poses; mapper.take_poses(poses);) {
    finished.tracked += static_cast<std::uint32_t>(poses.poses.size());
    author.write(Lane::poses, RecordKind::trajectory, poses);
  }
  for (auto blocks = mapper.map().take_settled(0, 100); !blocks.empty(); blocks = mapper.map().take_settled(0, 100)) {
    author.write(Lane::voxels, RecordKind::submap, make_submap(mapper.map(), blocks));
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
  explicit Robot(Author author, Duration merge_while_mapping = Duration::zero()) : author_(std::move(author)) {
    TeamMapConfig config;
    config.atlas.map.budget_bytes = 32u << 20;
    config.merge_while_mapping = merge_while_mapping;
    config.lost_after = kLostAfter;
    map_.emplace(author_.id(), author_.incarnation(), config);
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void apply(const RecordPtr& record, Instant now = kNow) {
    held_.push_back(record);
    map_->apply(record, now);
  }
  void apply(const Records& records) {
    for (const RecordPtr& record : records) apply(record);
  }
  // Works until nothing is left to do; returns what it published. Everybody but the silent was heard just now.
  Records work(Instant now = kNow, const std::set<RobotId>& silent = {}) {
    hear(now, silent);
    Records published;
    for (;;) {
      const bool busy = map_->step(now);
      map_->observe(now);
      const auto events = map_->take_events();
      events_.insert(events_.end(), events.begin(), events.end());
      const auto records = map_->take_records();
      if (!busy && records.empty()) return published;
      for (const TeamRecord& record : records) {
        published.push_back(author_.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body));
        apply(published.back(), now);
      }
    }
  }
  const Records& held() const { return held_; }
  TeamMap& map() { return *map_; }
  const TeamMap& map() const { return *map_; }
  const TeamView& view() const { return map_->view(); }
  RobotId id() const { return author_.id(); }
  // What happened so far, of one kind.
  template <class Event>
  std::vector<Event> events() const {
    std::vector<Event> out;
    for (const TeamEvent& event : events_)
      if (const auto* e = std::get_if<Event>(&event)) out.push_back(*e);
    return out;
  }

 private:
  void hear(Instant now, const std::set<RobotId>& silent) {
    for (const auto& [robot, member] : map_->members())
      if (!silent.contains(robot)) last_sign_[robot] = now;
    map_->presence(last_sign_, {});
  }
  Author author_;
  Records held_;
  std::map<RobotId, Instant> last_sign_;
  std::vector<TeamEvent> events_;
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
  EXPECT_FALSE(robot.map().members().at(stranger().id()).trajectory().empty());
  const auto solution = robot.map().solution();
  ASSERT_TRUE(solution.has_value());
  for (const auto& solved : solution->robots) EXPECT_NE(solved.robot, stranger().id());
  for (const auto& link : robot.map().links())
    EXPECT_EQ(link.reason == LinkReason::accepted, link.b == second().id()) << link.b.name();
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
      auto finished = decode_finished(body).value();
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
  TeamMap map(first().id(), 1, {});
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) map.apply(record, kNow);
  int asked = 0;
  EXPECT_FALSE(map.step(kNow, [&] { return ++asked > 3; }));
  EXPECT_EQ(asked, 4);
  EXPECT_TRUE(map.take_records().empty());
  EXPECT_TRUE(map.step(kNow));  // and the pair is verified as if nothing had been
  const auto records = map.take_records();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].kind, RecordKind::link);
}

TEST(TeamMap, MergesWhileRobotsMapAndEndsWithTheSameMap) {
  const Records all = whole_team({&first(), &second()});
  Robot expected(listener());
  expected.apply(all);
  expected.work();

  const auto finished = [](const RecordPtr& r) { return r->kind == static_cast<std::uint16_t>(RecordKind::finished); };
  Robot robot1(first(), 10s);
  Records last;
  for (const Author* author : {&first(), &second()})
    for (const RecordPtr& record : author->written()) finished(record) ? last.push_back(record) : robot1.apply(record);
  Instant now = kNow + 100s;
  EXPECT_FALSE(robot1.work(now).empty());
  EXPECT_EQ(robot1.view().robots_finished, 0u);
  EXPECT_EQ(robot1.view().robots_in_map, 2u);
  EXPECT_NE(robot1.view().digest, 0u);
  EXPECT_FALSE(robot1.view().settled);
  EXPECT_TRUE(robot1.work(now + 60s).empty()) << "nothing new, nothing done";
  robot1.apply(last);
  robot1.work(now);
  EXPECT_TRUE(robot1.view().settled);
  EXPECT_EQ(robot1.view().digest, expected.view().digest);
}

// What robot1 wrote when it died: no Finished, and its last submap is nowhere. It is the lowest id: it would verify its
// pairs and decide.
Records of_the_dead(std::size_t submaps_lost = 1) {
  Records out;
  for (const RecordPtr& record : first().written())
    if (record->kind != static_cast<std::uint16_t>(RecordKind::finished)) out.push_back(record);
  for (auto at = out.rbegin(); submaps_lost > 0; ++at)
    if ((*at)->kind == static_cast<std::uint16_t>(RecordKind::submap)) {
      out.erase(std::next(at).base());
      at = out.rbegin();
      --submaps_lost;
    }
  return out;
}

TEST(TeamMap, ARobotThatDiedIsNotWaitedForForEverAndTheNextDoesItsWork) {
  std::deque<Robot> robots;
  Records all = of_the_dead();
  for (const Author* author : {&second(), &stranger()}) {
    robots.emplace_back(*author);
    all.insert(all.end(), author->written().begin(), author->written().end());
  }
  for (Robot& robot : robots) robot.apply(all);
  const std::set<RobotId> silent{first().id()};
  const auto rounds = [&](Instant now) {
    for (bool news = true; news;) {
      news = false;
      for (Robot& robot : robots)
        for (const RecordPtr& record : robot.work(now, silent)) {
          news = true;
          all.push_back(record);
          for (Robot& other : robots)
            if (&other != &robot) other.apply(record, now);
        }
    }
  };
  rounds(kNow + 50s);
  for (const Robot& robot : robots) {
    EXPECT_FALSE(robot.view().settled);
    EXPECT_TRUE(robot.view().gone.empty());
    ASSERT_EQ(robot.view().waiting.size(), 1u);
    EXPECT_EQ(robot.view().waiting[0].robot, first().id());
    EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::end);
    EXPECT_EQ(robot.view().waiting[0].silent, Duration(50s));
  }
  rounds(kNow + 61s);
  for (const Robot& robot : robots) {
    EXPECT_TRUE(robot.view().settled);
    EXPECT_TRUE(robot.view().waiting.empty());
    EXPECT_THAT(robot.view().gone, testing::ElementsAre(first().id()));
    EXPECT_THAT(robot.view().cut_short, testing::ElementsAre(first().id()));
    EXPECT_EQ(robot.events<RobotGone>().size(), 1u);
    EXPECT_EQ(robot.view().digest, robots[0].view().digest);
    EXPECT_EQ(robot.view().robots_in_map, 2u) << "what the dead one had written is in the map";
  }
  // A robot that never heard it alive holds the same map from the same records.
  Robot late(listener());
  late.apply(shuffled(all, 3));
  late.work(kNow + 1000s, silent);
  EXPECT_TRUE(late.view().settled);
  EXPECT_EQ(late.view().digest, robots[0].view().digest);

  // It comes back, with the rest of what it wrote, and the team ends as if nothing had been.
  Robot& decider = robots[0];
  std::set<RecordId> known;
  for (const RecordPtr& record : decider.held()) known.insert(record->id);
  Robot alive(first());
  alive.apply(first().written());
  for (const RecordPtr& record : all)
    if (record->id.log.robot != first().id()) alive.apply(record);
  const Instant now = kNow + 70s;
  for (const RecordPtr& record : alive.held())
    if (!known.contains(record->id)) decider.apply(record, now);
  decider.work(now);
  EXPECT_TRUE(decider.view().gone.empty());
  EXPECT_FALSE(decider.view().settled) << "its link is its own work again";
  for (const RecordPtr& record : alive.work(now)) decider.apply(record, now);
  decider.work(now);
  Robot expected(listener());
  expected.apply(whole_team({&first(), &second(), &stranger()}));
  expected.work();
  EXPECT_TRUE(decider.view().settled);
  EXPECT_EQ(decider.view().digest, expected.view().digest);
  EXPECT_EQ(decider.events<RobotBack>().size(), 1u);
}

// Small robots whose links are written by hand: what counts is who decides.
struct Decisions : testing::Test {
  Author a = test::small_robot("a"), b = test::small_robot("b"), c = test::small_robot("c");
  Robot robot{listener()};
  SolutionRecord right;

  void SetUp() override {
    a.link(test::link_of("a", "b", 100));
    a.link(test::link_of("a", "c", 50));
    b.link(test::link_of("b", "c", 70));
    for (Author* author : {&a, &b, &c}) {
      author->finish();
      robot.apply(author->written());
    }
    right = solve(std::vector{a.id(), b.id(), c.id()}, robot.map().links());
  }
};

TEST_F(Decisions, OnlyWhatTheLinksSayIsFused) {
  SolutionRecord wrong = right;
  wrong.robots.back().T_global_robot.t_10um[0] += 1;
  robot.apply(a.solution(wrong));
  robot.work();
  EXPECT_EQ(robot.view().digest, 0u);
  ASSERT_EQ(robot.view().waiting.size(), 1u);
  EXPECT_EQ(robot.view().waiting[0].robot, a.id());
  EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::solution);
  robot.apply(a.solution(right));
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  EXPECT_TRUE(robot.events<DeciderPassedOver>().empty());
}

TEST_F(Decisions, NobodyElsesSolutionCounts) {
  robot.apply(b.solution(right));
  robot.work();
  EXPECT_FALSE(robot.view().settled);
  EXPECT_EQ(robot.view().digest, 0u);
}

TEST_F(Decisions, WhoDecidesWronglyForLongIsPassedOver) {
  SolutionRecord wrong = right;
  wrong.robots.back().T_global_robot.t_10um[0] += 1;
  robot.apply(a.solution(wrong));
  robot.apply(b.solution(right));
  robot.work(kNow + 60s);
  EXPECT_FALSE(robot.view().settled);
  robot.work(kNow + 121s);
  robot.work(kNow + 122s);
  EXPECT_TRUE(robot.view().settled) << "the next one's counts";
  const auto passed = robot.events<DeciderPassedOver>();
  ASSERT_EQ(passed.size(), 1u);
  EXPECT_EQ(passed[0].robot, a.id());
  EXPECT_TRUE(passed[0].published);
}

TEST_F(Decisions, AStrangerThatSortsFirstDecidesNothing) {
  Author evil("-evil");
  evil.hello();
  SubmapRecord broken{0, 20000, 60000, {{{100, 0, 0}, {}}}};
  broken.blocks[0].voxels[7] = {kTsdfOne + 1, 1, {}};
  evil.write(Lane::voxels, RecordKind::submap, broken);
  SolutionRecord own{evil.id(), {{evil.id(), {}}}, 0};
  evil.solution(own);
  evil.write(Lane::control, RecordKind::finished, FinishedRecord{0, 0, 0, 1});
  robot.apply(evil.written());
  robot.work();
  EXPECT_EQ(robot.view().digest, 0u) << "nobody who counts has decided";
  robot.apply(a.solution(right));
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  ASSERT_TRUE(robot.map().solution().has_value());
  EXPECT_EQ(encode(*robot.map().solution()), encode(right));
  EXPECT_EQ(robot.view().records_refused, 0u) << "what is not in the map is never decoded";
}

TEST_F(Decisions, ARecordInThisRobotsNameIsRefusedCountedAndSaid) {
  Robot victim(a);
  for (const Author* author : {&a, &b}) victim.apply(author->written());
  victim.work();
  ASSERT_TRUE(victim.view().settled);
  const std::uint64_t digest = victim.view().digest;
  Author forged("a", ~std::uint64_t{0});
  victim.apply(forged.hello());
  victim.apply(forged.finish());
  victim.work();
  EXPECT_TRUE(victim.view().settled);
  EXPECT_EQ(victim.view().digest, digest);
  EXPECT_EQ(victim.view().records_refused, 2u);
  ASSERT_EQ(victim.events<RecordRefused>().size(), 2u);
  EXPECT_THAT(victim.events<RecordRefused>()[0].reason, testing::HasSubstr("in this robot's own name"));
}

TEST_F(Decisions, UnderAnotherNumberThisRobotsRecordsComeAgain) {
  Robot self(a);
  for (const Author* author : {&a, &b}) self.apply(author->written());
  self.work();
  ASSERT_TRUE(self.view().settled);
  self.map().begin_life(7);
  EXPECT_FALSE(self.view().settled);
  EXPECT_EQ(self.map().members().count(a.id()), 0u);
  for (RecordPtr record : self.held())
    if (record->id.log.robot == a.id()) {
      Record again = *record;
      again.id.log.incarnation = 7;
      self.map().apply(std::make_shared<const Record>(std::move(again)), kNow);
    }
  EXPECT_EQ(self.map().members().at(a.id()).incarnation, 7u);
  EXPECT_EQ(self.map().members().at(a.id()).keyframes.size(), 3u);
}

// The lower robot lives and does not look: after a while the other one does.
TEST(TeamMap, APairThatIsNotLookedAtIsLookedAtByTheOther) {
  Author idle = test::small_robot("a"), mine = test::small_robot("b");
  idle.finish();
  mine.finish();
  Robot robot(mine);
  robot.apply(mine.written());
  robot.apply(idle.written());
  EXPECT_TRUE(robot.work(kNow).empty());
  ASSERT_EQ(robot.view().waiting.size(), 1u);
  EXPECT_EQ(robot.view().waiting[0].what, Waiting::What::link);
  EXPECT_TRUE(robot.work(kNow + 60s).empty());
  const Records published = robot.work(kNow + 61s);
  ASSERT_FALSE(published.empty());
  EXPECT_EQ(published[0]->kind, static_cast<std::uint16_t>(RecordKind::link));
  ASSERT_EQ(robot.map().links().size(), 1u);
  EXPECT_EQ(robot.map().links()[0].a, idle.id());
}

TEST(TeamMap, AnEmptyMapIsNotSettledOnInSilence) {
  Author deep("a");
  deep.hello();
  const RecordPtr refused = deep.write(Lane::voxels, RecordKind::submap, SubmapRecord{0, 10000, 1'010'000, {}});
  deep.write(Lane::control, RecordKind::finished, FinishedRecord{1, 0, 0, 1});
  Robot robot(deep);
  robot.apply(deep.written());
  robot.work();
  EXPECT_TRUE(robot.view().settled);
  EXPECT_EQ(robot.view().blocks, 0u);
  EXPECT_EQ(robot.view().submaps_refused, 1u);
  const auto settled = robot.events<MapSettled>();
  ASSERT_EQ(settled.size(), 1u);
  EXPECT_EQ(settled[0].blocks, 0u);
  EXPECT_EQ(settled[0].submaps_refused, 1u);
  EXPECT_EQ(robot.events<RecordRefused>().at(0).id, refused->id);
}

TEST(TeamMap, AFullGlobalMapIsSaid) {
  Author wide("a");
  wide.hello();
  for (int i = 0; i < 40; ++i) wide.submap({2 * i, 0, 0});
  wide.finish();
  TeamMapConfig config;
  config.atlas.map.budget_bytes = 200'000;
  TeamMap map(wide.id(), 1, config);
  for (const RecordPtr& record : wide.written()) map.apply(record, kNow);
  for (int i = 0; i < 3; ++i) {
    map.step(kNow);
    for (const TeamRecord& record : map.take_records())
      map.apply(wide.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body), kNow);
    map.observe(kNow);
  }
  EXPECT_TRUE(map.view().settled);
  EXPECT_GT(map.view().blocks_refused, 0u);
  EXPECT_EQ(map.view().blocks, map.map()->capacity());
}

}  // namespace
}  // namespace onemap::mapping
