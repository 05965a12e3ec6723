// What the radio tells others: its view for the rest of the daemon, and lines for people.
#include <fmt/format.h>

#include <utility>

#include "comms/fingerprint.hpp"
#include "daemon/clock.hpp"
#include "daemon/radio.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kConflictFresh = std::chrono::seconds(10);

std::map<std::string, std::uint64_t> refusals(const comms::Counters& counters) {
  std::map<std::string, std::uint64_t> out;
  for (std::size_t i = 0; i < comms::kRefusalCount; ++i)
    if (counters.refused[i] > 0) out[std::string(name(static_cast<comms::Refusal>(i)))] = counters.refused[i];
  return out;
}
}  // namespace

// Each reason by itself, at most once a second, and only when it happened again.
void Radio::log_refusals() {
  const comms::Counters counted = counters();
  for (std::size_t i = 0; i < comms::kRefusalCount; ++i) {
    const auto reason = static_cast<comms::Refusal>(i);
    std::uint64_t& logged = logged_refusals_[i];
    if (counted.refused[i] == logged || comms::everyday(reason)) continue;
    if (log_.limited(fmt::format("refused {}", name(reason)), "refused: {} ({} so far)", words(reason),
                     counted.refused[i]))
      logged = counted.refused[i];
  }
}

comms::DiskFault Radio::disk_fault() const {
  return store_.kept == nullptr ? comms::DiskFault::none : store_.kept->view().fault;
}

void Radio::log_disk() {
  const comms::DiskFault fault = disk_fault();
  if (std::exchange(disk_fault_, fault) == fault) return;
  if (fault == comms::DiskFault::none) return log_.line("{}/log is written again", config_.out);
  log_.warn(
      "{}/log: the disk {}; the robot goes on, but keyframes and voxels are left out of the map until it is back: make "
      "room on it, mount it again, or replace it",
      config_.out, words(fault));
}

// Who served what, so that somebody can look after that robot.
void Radio::log_complaints() {
  while (const auto complaint = node_->next_complaint()) {
    const LogId& log = complaint->record.log;
    log_.limited(fmt::format("complaint {} {}", name(complaint->reason), log.robot.name()),
                 "record {} of {} in lane {}, from {} at {}: {}", complaint->record.seq, log.robot.name(), log.lane,
                 complaint->from.name(), comms::to_string(complaint->endpoint), words(complaint->reason));
  }
}

void Radio::log_conflict(Instant now) {
  const auto conflict = node_->id_conflict();
  if (conflict && now - conflict->when < kConflictFresh)
    log_.limited("id conflict", "id {} is also in use at {}; give one of the two another --id", config_.id,
                 comms::to_string(conflict->where));
}

// A robot that is not the one that its name says, or that lies, is news for the people of its team.
void Radio::log_guard() {
  if (!guard_) return;
  seal_->keep_pins(log_);
  comms::GuardEvent event;
  while (guard_->next_event(event)) {
    const std::string who = fmt::format("{} at {} (key {})", event.robot.name(), comms::to_string(event.where),
                                        comms::fingerprint(event.key));
    if (event.what == comms::GuardEvent::What::other_key)
      log_.limited(
          "other key " + event.robot.name(),
          "{} shows another key than the robot of that name that was here before: it is refused. If it was set "
          "up anew, remove its line in {}",
          who, seal_->known_robots_file());
    else
      log_.warn(
          "{} has the team's key and sends what is no message: it is broken, or somebody has its key. Nothing is "
          "taken from it for {} s",
          who, std::chrono::duration_cast<std::chrono::seconds>(event.penalty).count());
  }
}

void Radio::update_view(Instant now) {
  RadioView view;
  view.life = node_config_.incarnation;
  view.frontier_digest = node_->frontier_digest();
  for (const auto& [robot, presence] : node_->presence(now)) view.last_sign[robot] = presence.last_sign;
  for (const auto& [robot, status] : node_->team())
    if (robot != node_config_.self) view.map_digests[robot] = status.map_digest;
  const std::set<RobotId> incomplete = node_->incomplete();
  for (const auto& [robot, sign] : view.last_sign)
    if (!incomplete.contains(robot)) view.records_complete.insert(robot);
  view.left_out = published_.refused;
  view.needless_named = named_;
  view.let_go = let_go_;
  view.store_full = node_->store_full();
  view.robots_heard = view.last_sign.size();
  view.neighbours_heard = alive_.size();
  view.records_missing = node_->records_missing();
  view.counters = counters();
  view.bytes_sent = sent_before_ + view.counters.bytes_sent;
  view.bytes_received = received_before_ + view.counters.bytes_received;
  for (const comms::Endpoint& peer : node_->peers_never_heard()) view.peers_never_heard.push_back(to_string(peer));
  const auto conflict = node_->id_conflict();
  if (conflict && now - conflict->when < kConflictFresh) view.id_also_used_at = to_string(conflict->where);
  view.scalars = node_->scalars();
  view.memory = node_->memory_view();
  view.refused = refusals(view.counters);
  if (not_loopback_ > 0) view.refused["not_loopback"] = not_loopback_;
  if (failed_before_ > 0 && !config_.alone()) view.refused["not_sent"] = failed_before_;
  view.delivered = node_->delivered(1);
  view.neighbours = node_->neighbours();
  view.records = records_;
  const std::lock_guard lock(mutex_);
  view.agrees = node_->team_agrees(comms::kStatusFinished, gone_);
  view.agreed_digest = view.agrees ? said_digest_ : 0;
  view_ = std::move(view);
}

}  // namespace onemap::daemon
