#include "daemon/team.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/clock.hpp"
#include "daemon/team_words.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kLookForWork = std::chrono::milliseconds(250);
constexpr auto kPatience = std::chrono::seconds(1);
constexpr auto kTeamStuckAfter = std::chrono::seconds(30);  // one piece of work, on a slow machine
}  // namespace

Team::Team(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config, Publish publish,
           Failures& failures, Log& log)
    : failures_(failures),
      log_(log),
      publish_(std::move(publish)),
      map_(self, incarnation, config),
      heartbeat_("team", kTeamStuckAfter) {}

Team::~Team() { stop(); }

void Team::start() {
  thread_.start("team", failures_, [this] { run(); });
}

void Team::stop(Duration for_the_map) {
  for_the_map_ns_ = for_the_map.count();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  caught_up_.notify_all();
  thread_.join();
}

void Team::apply(std::shared_ptr<const Record> record) {
  {
    const std::lock_guard lock(mutex_);
    inbox_.bytes += record->body.size();
    inbox_.records.push_back(std::move(record));
    view_.settled = false;  // until the thread has looked at it
  }
  wake_.notify_one();
}

bool Team::has_room() const {
  const std::lock_guard lock(mutex_);
  return inbox_.bytes < kInboxBytes;
}

void Team::catch_up() {
  std::unique_lock lock(mutex_);
  caught_up_.wait_for(lock, kPatience, [&] { return stopping_ || view_.unthinned <= kMostUnthinned; });
}

void Team::begin_life(std::uint64_t incarnation, bool repeats) {
  {
    const std::lock_guard lock(mutex_);
    inbox_.new_life = {incarnation, repeats};
    view_.settled = false;
  }
  wake_.notify_one();
}

void Team::presence(const std::map<RobotId, Instant>& last_sign, const std::set<RobotId>& records_complete) {
  const std::lock_guard lock(mutex_);
  inbox_.last_sign = last_sign;
  inbox_.records_complete = records_complete;
  inbox_.presence = true;
}

void Team::ask(Question question) {
  {
    const std::lock_guard lock(mutex_);
    inbox_.questions.push_back(std::move(question));
  }
  wake_.notify_one();
}

TeamView Team::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

LinkTally Team::links() const {
  const std::lock_guard lock(mutex_);
  return links_;
}

Team::Inbox Team::take(bool wait) {
  std::unique_lock lock(mutex_);
  // Some work becomes due by time alone.
  if (wait) wake_.wait_for(lock, kLookForWork, [&] { return stopping_ || !inbox_.empty(); });
  return std::exchange(inbox_, {});
}

void Team::apply_all(Inbox inbox, Instant arrived) {
  if (inbox.new_life) map_.begin_life(inbox.new_life->first, inbox.new_life->second);
  if (inbox.presence) map_.presence(std::move(inbox.last_sign), std::move(inbox.records_complete));
  for (const auto& record : inbox.records) {
    heartbeat_.beat(now());
    map_.apply(record, arrived);
    hand_out();  // at once: what is refused must not pile up
  }
  std::ranges::move(inbox.questions, std::back_inserter(open_));
}

void Team::hand_out() {
  for (const mapping::TeamEvent& event : map_.take_events()) {
    say(event, log_);
    if (told_) told_(event);
    const std::lock_guard lock(mutex_);
    links_.add(event);
  }
  for (mapping::TeamRecord& record : map_.take_records()) publish_({record.lane, record.kind, std::move(record.body)});
  mapping::SpareRecords spare = map_.take_spare();
  if (given_ && !spare.empty()) given_(std::move(spare));
}

void Team::answer() {
  std::erase_if(open_, [&](const Question& question) { return question(map_); });
  hand_out();
}

void Team::show() {
  {
    const std::lock_guard lock(mutex_);
    view_ = map_.view();
    view_.settled = view_.settled && inbox_.empty();
  }
  caught_up_.notify_all();
}

void Team::run() {
  bool busy = false;
  while (!stopping_) {
    heartbeat_.beat(now());
    Inbox inbox = take(!busy);
    const Instant arrived = now();
    apply_all(std::move(inbox), arrived);
    answer();
    if (stopping_) break;
    const Instant began = now();
    const Duration used_before = thread_cpu_time();
    busy = map_.step(began, [this] {
      heartbeat_.beat(now());
      return stopping_.load();
    });
    const Instant done = now();
    // Of a stop in the middle (SIGSTOP, a machine that slept) only what was worked counts.
    map_.took(std::min<Duration>(done - began, 10 * (thread_cpu_time() - used_before)));
    map_.observe(done);
    hand_out();
    show();
  }
  apply_all(take(false), now());  // what came since
  const Instant end = now() + Duration(for_the_map_ns_);
  map_.finish_fusion([&] { return now() > end; });
  map_.observe(now());
  hand_out();
  show();
  heartbeat_.rest();
}

}  // namespace onemap::daemon
