#include "mapping/team/team_log.hpp"

#include "mapping/records/kind.hpp"

namespace onemap::mapping {

namespace {

bool shapes_the_graph(std::uint16_t kind) {
  const auto k = static_cast<RecordKind>(kind);
  return k == RecordKind::hello || k == RecordKind::keyframe || k == RecordKind::link || k == RecordKind::finished;
}

}  // namespace

void TeamLog::begin_life(std::uint64_t incarnation) {
  incarnation_ = incarnation;
  members_.erase(self_);
  ++revision_;
}

Result<TeamMember*> TeamLog::member_of(const LogId& log) {
  if (!log.robot.valid()) return Error{"record", "of a robot without a valid name"};
  // Nobody else writes for this robot: what claims a later life of it is forged.
  if (log.robot == self_ && log.incarnation > incarnation_)
    return Error{"record", "in this robot's own name, of a life that it has not begun"};
  if (log.robot == self_ && log.incarnation < incarnation_) return static_cast<TeamMember*>(nullptr);
  if (members_.size() >= kMaxRobots && !members_.contains(log.robot))
    return Error{"record", "of one robot more than a team may have"};
  TeamMember& member = members_[log.robot];
  if (log.incarnation < member.incarnation) return static_cast<TeamMember*>(nullptr);
  if (log.incarnation > member.incarnation) {
    member = TeamMember{};
    ++revision_;
    member.incarnation = log.incarnation;
  }
  return &member;
}

Result<bool> TeamLog::apply(const RecordPtr& record, Instant now) {
  auto member = member_of(record->id.log);
  if (!member) return member.error();
  if (*member == nullptr) return false;
  (*member)->heard = now;
  if (shapes_the_graph(record->kind)) ++revision_;
  if (const Status status = (*member)->apply(record); !status) return status.error();
  return true;
}

const TeamMember* TeamLog::find(const RobotId& robot) const {
  const auto at = members_.find(robot);
  return at == members_.end() ? nullptr : &at->second;
}

std::vector<RobotId> TeamLog::robots() const {
  std::vector<RobotId> ids;
  for (const auto& [id, member] : members_)
    if (member.counts()) ids.push_back(id);
  return ids;
}

}  // namespace onemap::mapping
