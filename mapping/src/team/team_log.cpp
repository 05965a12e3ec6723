#include "mapping/team/team_log.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>

#include "mapping/records/kind.hpp"

namespace onemap::mapping {

namespace {

bool shapes_the_graph(const Record& record) {
  const auto k = static_cast<RecordKind>(record.kind);
  return k == RecordKind::hello || k == RecordKind::keyframe || k == RecordKind::link || k == RecordKind::finished ||
         k == RecordKind::ruling || (k == RecordKind::submap && record.seal.replaces < record.id.seq);
}

}  // namespace

void TeamLog::begin_life(std::uint64_t incarnation, bool repeats) {
  if (repeats) {
    members_.erase(self_);
    repeated_ = self_.incarnation;
    rulings_ = Rulings(members_);
  }
  self_.incarnation = incarnation;
  ++revision_;
}

// A life more of a robot; the earliest of too many goes.
TeamMember* TeamLog::begin(const ChainId& chain) {
  const auto first = members_.lower_bound({chain.robot, 0});
  const auto last = members_.upper_bound({chain.robot, std::numeric_limits<std::uint64_t>::max()});
  if (static_cast<std::size_t>(std::distance(first, last)) >= kMaxLives) {
    if (chain < first->first) return nullptr;
    members_.erase(first);
    rulings_ = Rulings(members_);
  }
  ++revision_;
  TeamMember& member = members_[chain];
  member.incarnation = chain.incarnation;
  member.submaps = SubmapLog(bodies_elsewhere_);
  return &member;
}

Result<TeamMember*> TeamLog::member_of(const LogId& log) {
  if (!log.robot.valid()) return Error{"record", "of a robot without a valid name"};
  // Nobody else writes for this robot: what claims a later life of it is forged.
  if (log.robot == self_.robot && log.incarnation > self_.incarnation)
    return Error{"record", "in this robot's own name, of a life that it has not begun"};
  if (log.robot == self_.robot && log.incarnation == repeated_) return static_cast<TeamMember*>(nullptr);
  const ChainId chain{log.robot, log.incarnation};
  if (const auto known = members_.find(chain); known != members_.end()) return &known->second;
  std::set<RobotId> robots;
  for (const auto& [id, member] : members_) robots.insert(id.robot);
  if (robots.size() >= kMaxRobots && !robots.contains(log.robot))
    return Error{"record", "of one robot more than a team may have"};
  return begin(chain);
}

Result<bool> TeamLog::apply(const RecordPtr& record, Instant now) {
  auto member = member_of(record->id.log);
  if (!member) return member.error();
  if (*member == nullptr) return false;
  (*member)->heard = now;
  if (shapes_the_graph(*record)) ++revision_;
  if (const Status status = (*member)->apply(record); !status) return status.error();
  if (static_cast<RecordKind>(record->kind) == RecordKind::ruling) rulings_ = Rulings(members_);
  return true;
}

std::vector<RecordId> TeamLog::let_go(const ChainId& chain, std::size_t submaps) {
  const auto at = members_.find(chain);
  return at == members_.end() ? std::vector<RecordId>() : at->second.submaps.let_go(submaps);
}

std::vector<RecordId> TeamLog::let_go_keyframes(const ChainId& chain) {
  const auto at = members_.find(chain);
  return at == members_.end() ? std::vector<RecordId>() : at->second.keyframes.let_go();
}

const TeamMember* TeamLog::find(const ChainId& chain) const {
  const auto at = members_.find(chain);
  return at == members_.end() ? nullptr : &at->second;
}

ChainId TeamLog::present(const RobotId& robot) const {
  if (robot == self_.robot) return self_;
  const auto after = members_.upper_bound({robot, std::numeric_limits<std::uint64_t>::max()});
  if (after == members_.begin() || std::prev(after)->first.robot != robot) return {robot, 0};
  return std::prev(after)->first;
}

std::vector<RobotId> TeamLog::robots() const {
  std::vector<RobotId> ids;
  for (const auto& [chain, member] : members_)
    if (member.counts() && chain == present(chain.robot)) ids.push_back(chain.robot);
  return ids;
}

std::vector<ChainId> TeamLog::chains() const {
  std::set<ChainId> repeated;
  for (const auto& [chain, member] : members_)
    if (member.repeats != 0 && member.repeats < chain.incarnation) repeated.insert({chain.robot, member.repeats});
  std::vector<ChainId> out;
  for (const auto& [chain, member] : members_)
    if (member.counts() && !repeated.contains(chain)) out.push_back(chain);
  return out;
}

}  // namespace onemap::mapping
