#pragma once
// Robots of a team with nothing but their TeamMaps: no threads, no sockets; what one publishes is handed to the others.
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/team/team_map.hpp"
#include "support/random.hpp"
#include "support/team_author.hpp"

namespace onemap::test {

using namespace mapping;
using Records = std::vector<RecordPtr>;

inline constexpr Instant kNow{};
inline constexpr Duration kLostAfter = std::chrono::seconds(60);

// A robot's whole mapping of a simulated camera, as records.
inline Author explore(const std::string& name, const std::string& camera_text, std::uint64_t incarnation = 1) {
  Author author(name, incarnation);
  auto camera = std::move(hal::open_simulated(*hal::parse_camera_address(camera_text)).value());
  hal::FramePool pool(camera->intrinsics(), 2);
  LocalMapperConfig config;
  config.max_keyframes = 60;
  config.map.budget_bytes = 16u << 20;
  LocalMapper mapper(config, camera->intrinsics());
  author.write(Lane::control, RecordKind::hello, HelloRecord{name, camera_text});
  FinishedRecord finished;
  std::vector<SubmapRecord> submaps;
  const auto take_submaps = [&] {
    for (SubmapRecord submap; mapper.take_submap(submap);) submaps.push_back(submap);
  };
  for (; camera; ++finished.frames) {
    hal::Frame frame = pool.acquire();
    if (camera->grab(frame, std::chrono::milliseconds(0)) != hal::Grab::frame) break;
    mapper.process(frame.view());
    take_submaps();
  }
  mapper.finish();
  take_submaps();
  KeyframeRecord keyframe;
  for (; mapper.take_keyframe(keyframe); ++finished.keyframes)
    author.write(Lane::features, RecordKind::keyframe, keyframe);
  for (TrajectoryRecord poses; mapper.take_poses(poses);) {
    finished.tracked += static_cast<std::uint32_t>(poses.poses.size());
    author.write(Lane::poses, RecordKind::trajectory, poses);
  }
  for (const SubmapRecord& submap : submaps) author.write(Lane::voxels, RecordKind::submap, submap);
  finished.submaps = static_cast<std::uint32_t>(submaps.size());
  author.write(Lane::control, RecordKind::finished, finished);
  return author;
}

inline const Author& first() {
  static const Author author = explore("robot1", "simulated:living-room?robot=1&robots=3&frames=60&seed=3");
  return author;
}
inline const Author& second() {
  static const Author author = explore("robot2", "simulated:living-room?robot=2&robots=3&frames=60&seed=3");
  return author;
}
inline const Author& stranger() {
  static const Author author = explore("robot3", "simulated:storage?robot=1&robots=3&frames=40&seed=3");
  return author;
}

inline AtlasConfig small_map() {
  AtlasConfig out;
  out.map.budget_bytes = 32u << 20;
  return out;
}

// One robot of the team with nothing but its TeamMap; what it publishes goes into its log and back to it.
class Robot {
 public:
  // The mapping that this robot did itself is taken over, so that what it publishes continues the logs.
  explicit Robot(Author author, Duration merge_while_mapping = Duration::zero(), const AtlasConfig& atlas = small_map())
      : author_(std::move(author)) {
    TeamMapConfig config;
    config.atlas = atlas;
    config.merge_while_mapping = merge_while_mapping;
    begin(config);
  }
  Robot(Author author, const TeamMapConfig& config) : author_(std::move(author)) { begin(config); }
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
    while (work_once(now, published)) continue;
    return published;
  }
  // One piece of work, which is said to have taken so long; false: there was none.
  bool work_once(Instant now, Records& published, Duration cost = Duration::zero()) {
    const bool busy = map_->step(now);
    if (cost > Duration::zero()) map_->took(cost);
    map_->observe(now);
    const auto events = map_->take_events();
    events_.insert(events_.end(), events.begin(), events.end());
    const auto records = map_->take_records();
    for (const TeamRecord& record : records) {
      published.push_back(author_.write(record.lane, static_cast<std::uint16_t>(record.kind), record.body));
      apply(published.back(), now);
    }
    return busy || !records.empty();
  }
  // It writes a link itself.
  RecordPtr say(const LinkRecord& link) {
    const RecordPtr record = author_.link(link);
    apply(record);
    return record;
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
  void begin(TeamMapConfig config) {
    config.lost_after = kLostAfter;
    map_.emplace(author_.id(), author_.incarnation(), config);
  }
  void hear(Instant now, const std::set<RobotId>& silent) {
    for (const auto& [chain, member] : map_->members())
      if (!silent.contains(chain.robot)) last_sign_[chain.robot] = now;
    map_->presence(last_sign_, {});
  }
  Author author_;
  Records held_;
  std::map<RobotId, Instant> last_sign_;
  std::vector<TeamEvent> events_;
  std::optional<TeamMap> map_;
};

// A team whose members hear all that is published.
class Team {
 public:
  explicit Team(const std::vector<const Author*>& authors, Records all = {}) : all_(std::move(all)) {
    for (const Author* author : authors) {
      robots_.emplace_back(*author);
      all_.insert(all_.end(), author->written().begin(), author->written().end());
    }
    for (Robot& robot : robots_) robot.apply(all_);
  }
  // Until nobody has anything to say.
  void work(Instant now = kNow, const std::set<RobotId>& silent = {}) {
    for (bool news = true; news;) {
      news = false;
      for (Robot& robot : robots_)
        for (const RecordPtr& record : robot.work(now, silent)) {
          news = true;
          all_.push_back(record);
          for (Robot& other : robots_)
            if (&other != &robot) other.apply(record, now);
        }
    }
  }
  std::deque<Robot>& robots() { return robots_; }
  const Records& all() const { return all_; }

 private:
  std::deque<Robot> robots_;
  Records all_;
};

// All records of a team, once its pairs are verified and the map is decided.
inline Records whole_team(const std::vector<const Author*>& authors) {
  Team team(authors);
  team.work();
  return team.all();
}

// The records in a random order that keeps each log's.
inline Records shuffled(const Records& records, std::uint64_t seed) {
  std::map<LogId, std::deque<RecordPtr>> logs;
  for (const RecordPtr& record : records) logs[record->id.log].push_back(record);
  Random random(seed);
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
inline Author listener() { return Author("zz-listener"); }

inline std::vector<std::vector<std::uint8_t>> links_of(const Robot& robot) {
  std::vector<std::vector<std::uint8_t>> out;
  for (const auto& link : robot.map().links()) out.push_back(encode(link));
  return out;
}

}  // namespace onemap::test
