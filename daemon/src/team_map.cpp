#include "daemon/team_map.hpp"

#include <algorithm>

#include "daemon/clock.hpp"
#include "mapping/team/reference.hpp"

namespace onemap::daemon {

const char* link_words(mapping::LinkReason reason) {
  switch (reason) {
    case mapping::LinkReason::accepted:
      return "accepted";
    case mapping::LinkReason::too_few_matches:
      return "too few matches";
    case mapping::LinkReason::fundamental_failed:
      return "no fundamental matrix";
    case mapping::LinkReason::depth_incoherent:
      return "depth does not agree";
    case mapping::LinkReason::ransac_failed:
      return "no rigid motion agrees";
    case mapping::LinkReason::icp_failed:
      return "the clouds do not fit";
    case mapping::LinkReason::inconsistent:
      return "pairs of clouds contradict each other";
  }
  return "a reason of a later version";
}

using mapping::RecordKind;

namespace {

bool equal(const std::optional<mapping::SolutionRecord>& a, const std::optional<mapping::SolutionRecord>& b) {
  return a.has_value() == b.has_value() && (!a || encode(*a) == encode(*b));
}

// Keyframes decode, for members keep only those.
mapping::KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member) {
  return {robot, member.keyframes.size(),
          [&member](std::size_t i) { return mapping::decode_keyframe(member.keyframes[i]->body).value(); }};
}

}  // namespace

TeamMap::TeamMap(const RobotId& self, const TeamMapConfig& config, Publish publish, Log& log)
    : self_(self),
      config_(config),
      publish_(std::move(publish)),
      log_(log),
      schedule_(config.merge_while_mapping),
      fusion_(config.atlas) {}

void TeamMap::apply(const std::shared_ptr<const Record>& record, Instant now) {
  TeamMember* member = member_of(record->id.log);
  if (!member) return;
  if (const Status status = take(*member, record); !status) {
    RefusedRecords& refused = refused_[record->kind];
    ++refused.count;
    refused.last_reason = status.error().text();
    log_.limited("record", "record {} of {} refused: {}", record->id.seq, record->id.log.robot.name(),
                 refused.last_reason);
  }
  if (!all_finished())
    all_finished_seen_ = false;
  else if (!all_finished_seen_) {
    all_finished_seen_ = true;
    all_finished_at_ = now;
  }
  settled_ = false;
}

TeamMember* TeamMap::member_of(const LogId& log) {
  TeamMember& member = members_[log.robot];
  if (log.incarnation < member.incarnation) return nullptr;
  if (log.incarnation > member.incarnation) {
    // The robot started anew: what its earlier life wrote goes with that life. Others' links to it name the life.
    std::erase_if(links_, [&](const auto& link) { return link.first.first == log.robot; });
    stale_ = stale_ || !member.submaps.empty();
    member = TeamMember{};
    member.incarnation = log.incarnation;
  }
  return &member;
}

Status TeamMap::take(TeamMember& member, const std::shared_ptr<const Record>& record) {
  if (static_cast<RecordKind>(record->kind) == RecordKind::link) return take_link(record->id.log.robot, record->body);
  Status status = member.apply(record);
  if (status) log_member(record->id.log.robot, member, record->kind);
  return status;
}

Status TeamMap::take_link(const RobotId& author, std::span<const std::uint8_t> body) {
  auto link = mapping::decode_link(body);
  if (!link) return link.error();
  if (link->a != author || !(link->a < link->b)) return Error{"link", "not written by the lower robot of its pair"};
  log_link(*link);
  links_.insert_or_assign(Pair{link->a, link->b}, *link);
  return success();
}

void TeamMap::log_member(const RobotId& id, const TeamMember& member, std::uint16_t kind) const {
  if (static_cast<RecordKind>(kind) == RecordKind::hello && id != self_)
    log_.line("robot {} joined with {}", member.name, member.camera);
  if (static_cast<RecordKind>(kind) == RecordKind::finished)
    log_.line("robot {} finished: {} frames, {} tracked, {} keyframes, {} submaps", id.name(), member.finished->frames,
              member.finished->tracked, member.finished->keyframes, member.finished->submaps);
}

void TeamMap::log_link(const mapping::LinkRecord& link) const {
  if (link.reason == mapping::LinkReason::accepted)
    log_.line("link {} - {} accepted: {} pairs of clouds agree, {} inliers, ratio {:.2f}, error {:.1f} mm",
              link.a.name(), link.b.name(), link.supporting_pairs, link.inliers, link.ratio_e4 * 1e-4,
              link.error_um * 1e-3);
  else
    log_.line("link {} - {} refused: {}, {} pairs of clouds agree, {} inliers", link.a.name(), link.b.name(),
              link_words(link.reason), link.supporting_pairs, link.inliers);
}

bool TeamMap::step(Instant now, const Stop& stop) { return verify_next_pair(now, stop) || decide() || fuse(now, stop); }

bool TeamMap::verify_next_pair(Instant now, const Stop& stop) {
  const auto self = members_.find(self_);
  if (self == members_.end()) return false;
  for (const auto& [other, member] : members_)
    if (self_ < other && schedule_.due(self->second, other, member, now)) return verify(other, now, stop);
  return false;
}

bool TeamMap::verify(const RobotId& other, Instant now, const Stop& stop) {
  const TeamMember &mine = members_.at(self_), &theirs = members_.at(other);
  auto link = mapping::verify_robots(keyframes_of(self_, mine), keyframes_of(other, theirs), config_.verify, stop);
  if (!link) return false;
  link->incarnation_b = theirs.incarnation;
  const bool linked = link->reason == mapping::LinkReason::accepted;
  const bool final = mine.keyframes_complete() && theirs.keyframes_complete();
  // While mapping, a refusal is only news when it takes a link back.
  if (final || linked || schedule_.linked(other, theirs))
    publish_({mapping::Lane::poses, RecordKind::link, encode(*link)});
  schedule_.verified(mine, other, theirs, linked, now, daemon::now());
  return true;
}

std::vector<RobotId> TeamMap::robots() const {
  std::vector<RobotId> ids;
  for (const auto& [id, member] : members_)
    if (!member.name.empty()) ids.push_back(id);
  return ids;
}

bool TeamMap::all_finished() const {
  return !members_.empty() &&
         std::ranges::all_of(members_, [](const auto& m) { return m.second.finished.has_value(); });
}

const mapping::LinkRecord* TeamMap::link_of(const RobotId& a, const RobotId& b) const {
  const auto link = links_.find({a, b});
  const auto member = members_.find(b);
  const bool counts =
      link != links_.end() && member != members_.end() && link->second.incarnation_b == member->second.incarnation;
  return counts ? &link->second : nullptr;
}

std::vector<mapping::LinkRecord> TeamMap::links() const {
  std::vector<mapping::LinkRecord> out;
  for (const auto& [pair, link] : links_)
    if (link_of(pair.first, pair.second)) out.push_back(link);
  return out;
}

bool TeamMap::all_linked() const {
  const auto ids = robots();
  for (std::size_t i = 0; i < ids.size(); ++i)
    for (std::size_t j = i + 1; j < ids.size(); ++j) {
      const TeamMember &a = members_.at(ids[i]), &b = members_.at(ids[j]);
      const mapping::LinkRecord* link = link_of(ids[i], ids[j]);
      if (!link || !a.keyframes_complete() || !b.keyframes_complete()) return false;
      if (link->keyframes_a != a.keyframes.size() || link->keyframes_b != b.keyframes.size()) return false;
    }
  return true;
}

std::optional<mapping::SolutionRecord> TeamMap::wanted_solution() const {
  if (!all_finished() || !all_linked()) return std::nullopt;
  return mapping::solve(robots(), links());
}

std::optional<mapping::SolutionRecord> TeamMap::interim_solution() const {
  if (config_.merge_while_mapping <= Duration::zero() || all_finished()) return std::nullopt;
  const auto all = links();
  const auto accepted = [](const auto& link) { return link.reason == mapping::LinkReason::accepted; };
  if (std::ranges::none_of(all, accepted)) return std::nullopt;
  return mapping::solve(robots(), all);
}

bool TeamMap::decide() {
  const auto ids = robots();
  if (ids.empty() || mapping::elect(ids) != self_) return false;
  auto wanted = wanted_solution();
  if (!wanted) wanted = interim_solution();
  if (!wanted || equal(wanted, published_)) return false;
  published_ = std::move(wanted);
  publish_({mapping::Lane::poses, RecordKind::solution, encode(*published_)});
  return true;
}

const mapping::SolutionRecord* TeamMap::current_solution() const {
  for (const auto& [id, member] : members_)
    if (member.solution) return &*member.solution;
  return nullptr;
}

std::size_t TeamMap::submaps_in(const mapping::SolutionRecord& solution) const {
  std::size_t count = 0;
  for (const auto& robot : solution.robots)
    if (const auto member = members_.find(robot.robot); member != members_.end())
      count += member->second.submaps.size();
  return count;
}

bool TeamMap::may_begin(const mapping::SolutionRecord& solution, Instant now) const {
  if (all_finished()) return equal(wanted_solution(), solution);
  return config_.merge_while_mapping > Duration::zero() && now >= next_interim_fusion_;
}

bool TeamMap::fuse(Instant now, const Stop& stop) {
  const mapping::SolutionRecord* solution = current_solution();
  if (!solution) return false;
  const bool current = !stale_ && equal(fusion_.solution(), *solution);
  // What was begun while robots map is finished first, even when its solution is out of date by then.
  if (!fusion_.underway() || (!current && (stale_ || all_finished()))) {
    if (current && fusion_.submaps() == submaps_in(*solution)) return false;
    if (!may_begin(*solution, now)) return false;
    fusion_.begin(*solution);
    stale_ = false;
    next_interim_fusion_ = now + config_.merge_while_mapping;
  }
  const auto member = members_.find(fusion_.next());
  if (member == members_.end()) return false;
  if (all_finished() && !member->second.complete()) return false;  // its voxels are still on their way
  const Instant began = daemon::now();
  if (!fusion_.add(member->second, stop)) return false;
  // Building maps while others are being built takes at most a tenth of the time.
  next_interim_fusion_ = next_interim_fusion_ + 10 * (daemon::now() - began);
  if (fusion_.done()) fused();
  return true;
}

void TeamMap::finish_fusion(const Stop& stop) {
  while (fusion_.underway()) {
    const auto member = members_.find(fusion_.next());
    if (member == members_.end() || !fusion_.add(member->second, stop)) break;
    if (fusion_.done()) fused();
  }
}

void TeamMap::fused() {
  const mapping::SolutionRecord& solution = *fusion_.solution();
  fused_anew_ = true;
  digest_ = fusion_.digest();
  robots_in_map_ = solution.robots.size();
  std::string names;
  for (const auto& robot : solution.robots) names.append(" ").append(robot.robot.name());
  log_.line("{} map {:016x}: reference {}, {} links, robots{}, {} submaps, {} blocks, {} refused",
            all_finished() ? "global" : "interim", digest_, solution.reference.name(), solution.links_used, names,
            fusion_.submaps(), fusion_.map()->used(), fusion_.map()->counters().blocks_refused);
}

std::optional<mapping::SolutionRecord> TeamMap::solution() const {
  return fusion_.done() ? fusion_.solution() : std::nullopt;
}

void TeamMap::observe(Instant now) {
  if (fused_anew_) fused_at_ = now;
  fused_anew_ = false;
  if (settled_ || stale_ || !fusion_.done()) return;
  for (const auto& [id, member] : members_)
    if (member.name.empty() || !member.complete()) return;
  const auto wanted = wanted_solution();
  settled_ = wanted && equal(wanted, fusion_.solution()) && fusion_.submaps() == submaps_in(*wanted);
}

TeamView TeamMap::view() const {
  TeamView view;
  view.robots_known = robots().size();
  for (const auto& [id, member] : members_) view.robots_finished += member.finished ? 1 : 0;
  view.settled = settled_;
  if (settled_) view.merge = std::max(Duration::zero(), fused_at_ - all_finished_at_);
  view.robots_in_map = robots_in_map_;
  view.digest = digest_;
  return view;
}

}  // namespace onemap::daemon
