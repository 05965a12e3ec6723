#include "daemon/team_member.hpp"

#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/submap.hpp"

namespace onemap::daemon {

using mapping::RecordKind;

namespace {

template <class Record>
Status keep(Result<Record> decoded, std::optional<Record>& place) {
  if (!decoded) return decoded.error();
  place = std::move(*decoded);
  return success();
}

Status keep_hello(const Record& record, TeamMember& member) {
  auto hello = mapping::decode_hello(record.body);
  member.name = hello ? hello->name : record.id.log.robot.name();  // whoever greets is there, however oddly
  if (!hello) return hello.error();
  member.camera = hello->camera;
  return success();
}

Status keep_keyframe(const std::shared_ptr<const Record>& record, TeamMember& member) {
  auto keyframe = mapping::decode_keyframe(record->body);
  if (!keyframe) return ++member.keyframes_refused, keyframe.error();
  member.keyframes.push_back(record);
  member.keyframe_poses.push_back(keyframe->T_robot_keyframe);
  return success();
}

Status keep_poses(const Record& record, TeamMember& member) {
  auto batch = mapping::decode_trajectory(record.body);
  if (!batch) return member.poses_refused = true, batch.error();
  member.poses.insert(member.poses.end(), batch->poses.begin(), batch->poses.end());
  return success();
}

Status keep_submap(const std::shared_ptr<const Record>& record, TeamMember& member) {
  if (auto submap = mapping::decode_submap(record->body); !submap) return ++member.submaps_refused, submap.error();
  member.submaps.push_back(record);
  return success();
}

}  // namespace

Status TeamMember::apply(const std::shared_ptr<const Record>& record) {
  switch (static_cast<RecordKind>(record->kind)) {
    case RecordKind::hello:
      return keep_hello(*record, *this);
    case RecordKind::keyframe:
      return keep_keyframe(record, *this);
    case RecordKind::trajectory:
      return keep_poses(*record, *this);
    case RecordKind::submap:
      return keep_submap(record, *this);
    case RecordKind::solution:
      return keep(mapping::decode_solution(record->body), solution);
    case RecordKind::finished:
      return keep(mapping::decode_finished(record->body), finished);
    case RecordKind::link:
      break;
  }
  return Error{"kind " + std::to_string(record->kind), "not known to this version"};
}

}  // namespace onemap::daemon
