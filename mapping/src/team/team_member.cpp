#include "mapping/team/team_member.hpp"

#include "hal/base/text.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keeping.hpp"
#include "mapping/records/kind.hpp"

namespace onemap::mapping {

namespace {

template <class Body>
Status keep(Result<Body> decoded, std::optional<Body>& place) {
  if (!decoded) return decoded.error();
  place = std::move(*decoded);
  return success();
}

Status keep_hello(const Record& record, TeamMember& member) {
  auto hello = decode_hello(record.body);
  if (!hello) return hello.error();
  if (hello->name != record.id.log.robot.name()) return Error{"hello record, name", "not that of the log's robot"};
  member.name = std::move(hello->name);
  member.camera = printable(hello->camera);
  member.repeats = hello->repeats;
  member.map_blocks = hello->map_blocks;
  return success();
}

Status keep_keyframe(const RecordPtr& record, TeamMember& member) {
  member.keyframes_refused += member.keyframes.size() == KeyframeLog::kMost ? 1 : 0;
  return member.keyframes.add(record);
}

Status keep_poses(const Record& record, TeamMember& member) {
  const auto batch = decode_trajectory(record.body);
  if (!batch) return member.poses_refused = true, batch.error();
  for (const StampedPose& pose : batch->poses) member.trajectory.add(pose);
  return success();
}

Status keep_link(const Record& record, TeamMember& member) {
  auto link = decode_link(record.body);
  if (!link) return link.error();
  const RobotId& author = record.id.log.robot;
  if (link->a != author && link->b != author) return Error{"link record", "not written by a robot of its pair"};
  const ChainId other{link->a == author ? link->b : link->a, link->incarnation_other};
  if (other == ChainId{author, record.id.log.incarnation})
    if (Status status = check_own_loops(*link); !status) return status;
  if (member.links.size() >= TeamMember::kMaxLinks && !member.links.contains(other))
    return Error{"link record", "this robot has links to as many lives as are looked at"};
  member.links.insert_or_assign(other, *link);
  return success();
}

Status keep_ruling(const Record& record, TeamMember& member) {
  const auto ruling = decode_ruling(record.body);
  if (!ruling) return ruling.error();
  const std::pair pair{ruling->a, ruling->b};
  if (member.rulings.size() >= TeamMember::kMaxRulings && !member.rulings.contains(pair))
    return Error{"ruling record", "this robot has said something of as many pairs as are looked at"};
  member.rulings.insert_or_assign(pair, *ruling);
  return success();
}

Status keep_solution(const Record& record, TeamMember& member) {
  Status status = keep(decode_solution(record.body), member.solution);
  if (status) member.solution_digest = digest(*member.solution);
  return status;
}

Status keep_frontier(const Record& record, TeamMember& member) {
  auto frontier = decode_frontier(record.body);
  if (!frontier) return frontier.error();
  member.frontiers.add(std::move(*frontier));
  return success();
}

}  // namespace

Status TeamMember::apply(const RecordPtr& record) {
  if (record->dropped && !may_be_replaced(static_cast<RecordKind>(record->kind))) {
    if (only_the_last_counts(static_cast<RecordKind>(record->kind))) return success();  // a later one took its place
    return Error{"kind " + std::to_string(record->kind), "its body was dropped, and nothing takes its place"};
  }
  switch (static_cast<RecordKind>(record->kind)) {
    case RecordKind::hello:
      return keep_hello(*record, *this);
    case RecordKind::keyframe:
      return keep_keyframe(record, *this);
    case RecordKind::trajectory:
      return keep_poses(*record, *this);
    case RecordKind::submap:
      return submaps.add(record);
    case RecordKind::link:
      return keep_link(*record, *this);
    case RecordKind::solution:
      return keep_solution(*record, *this);
    case RecordKind::frontier:
      return keep_frontier(*record, *this);
    case RecordKind::ruling:
      return keep_ruling(*record, *this);
    case RecordKind::finished:
      return keep(decode_finished(record->body), finished);
  }
  return Error{"kind " + std::to_string(record->kind), "not known to this version"};
}

}  // namespace onemap::mapping
