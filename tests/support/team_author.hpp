#pragma once
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/base/record.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/hello.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::test {

inline mapping::QuantizedPose two_metres_each(std::uint32_t count) {
  mapping::QuantizedPose out;
  out.t_10um[0] = static_cast<std::int32_t>(200'000 * count);
  return out;
}

// What one robot writes in one life, as records: each lane is one log.
class Author {
 public:
  explicit Author(const std::string& name, std::uint64_t incarnation = 1)
      : id_(RobotId::from_name(name)), incarnation_(incarnation) {}

  mapping::RecordPtr write(mapping::Lane lane, std::uint16_t kind, std::vector<std::uint8_t> body) {
    const auto number = static_cast<std::uint8_t>(lane);
    Record record{{{id_, number, incarnation_}, next_[number]++}, kind, std::move(body)};
    record.seal.replaces = std::exchange(replaces_, kNoSequence);
    written_.push_back(std::make_shared<const Record>(std::move(record)));
    return written_.back();
  }
  template <class Body>
  mapping::RecordPtr write(mapping::Lane lane, mapping::RecordKind kind, const Body& body) {
    return write(lane, static_cast<std::uint16_t>(kind), encode(body));
  }

  Author& replacing(std::uint32_t sequence) {  // the next record that is written replaces that one of its log
    replaces_ = sequence;
    return *this;
  }

  // Small records for where their content does not matter.
  mapping::RecordPtr hello() {
    return write(mapping::Lane::control, mapping::RecordKind::hello, mapping::HelloRecord{id_.name(), "test"});
  }
  mapping::RecordPtr keyframe() {
    mapping::KeyframeRecord body;
    body.index = body.anchor = keyframes_++;  // each two metres on, and its own anchor
    body.T_robot_keyframe = two_metres_each(body.index);
    return write(mapping::Lane::features, mapping::RecordKind::keyframe, body);
  }
  // One block, all of it seen.
  mapping::RecordPtr submap(const mapping::BlockKey& key = {}, std::uint8_t red = 9, std::uint32_t anchor = 0) {
    ++submaps_;
    mapping::SubmapRecord body{anchor, 20000, 60000, {{key, {}}}};
    for (auto& voxel : body.blocks[0].voxels) voxel = {5, 1, {red, 1, 1}};
    return write(mapping::Lane::voxels, mapping::RecordKind::submap, body);
  }
  mapping::RecordPtr pose(std::int64_t seconds) {
    ++poses_;
    mapping::TrajectoryRecord body;
    body.poses.push_back({frame_time_from_ns(seconds * 1'000'000'000), {}});
    return write(mapping::Lane::poses, mapping::RecordKind::trajectory, body);
  }
  mapping::RecordPtr link(const mapping::LinkRecord& body) {
    return write(mapping::Lane::poses, mapping::RecordKind::link, body);
  }
  mapping::RecordPtr solution(const mapping::SolutionRecord& body) {
    return write(mapping::Lane::poses, mapping::RecordKind::solution, body);
  }
  // Promises what was written with the functions above, and so many keyframes more.
  mapping::RecordPtr finish(std::uint32_t more_keyframes = 0) {
    return write(mapping::Lane::control, mapping::RecordKind::finished,
                 mapping::FinishedRecord{poses_, poses_, keyframes_ + more_keyframes, submaps_});
  }

  const std::vector<mapping::RecordPtr>& written() const& { return written_; }
  std::vector<mapping::RecordPtr> written() && { return std::move(written_); }
  RobotId id() const { return id_; }
  mapping::ChainId chain() const { return {id_, incarnation_}; }
  std::uint64_t incarnation() const { return incarnation_; }

 private:
  RobotId id_;
  std::uint64_t incarnation_;
  std::uint32_t keyframes_ = 0, submaps_ = 0, poses_ = 0, replaces_ = kNoSequence;
  std::map<std::uint8_t, std::uint32_t> next_;
  std::vector<mapping::RecordPtr> written_;
};

// What is left of it once its body was dropped.
inline mapping::RecordPtr without_body(const mapping::RecordPtr& record) {
  Record out{
      record->id, record->kind, {}, record->seal, DroppedBody{static_cast<std::uint32_t>(record->body.size()), {}}};
  return std::make_shared<const Record>(std::move(out));
}

// A robot that did a little of everything, and looked for its own loops; without its Finished.
inline Author small_robot(const std::string& name, std::uint64_t incarnation = 1) {
  Author author(name, incarnation);
  author.hello();
  for (int i = 0; i < 3; ++i) author.keyframe();
  author.pose(1);
  author.submap();
  mapping::LinkRecord loops;
  loops.a = loops.b = author.id();
  loops.incarnation_other = incarnation;
  loops.keyframes_a = loops.keyframes_b = 3;
  loops.reason = mapping::LinkReason::too_few_matches;
  author.link(loops);
  return author;
}

// Of robots with three keyframes each, in their first life, whose frames are one: every keyframe of the one was seen
// from every keyframe of the other.
inline mapping::LinkRecord link_of(const std::string& a, const std::string& b, std::uint32_t inliers = 100,
                                   mapping::LinkReason reason = mapping::LinkReason::accepted) {
  mapping::LinkRecord link;
  link.a = RobotId::from_name(a);
  link.b = RobotId::from_name(b);
  link.incarnation_other = 1;
  link.keyframes_a = link.keyframes_b = 3;
  link.supporting_pairs = reason == mapping::LinkReason::accepted ? 4 : 0;
  link.inliers = inliers;
  link.ratio_e4 = 2000;
  link.reason = reason;
  if (reason != mapping::LinkReason::accepted) return link;
  for (std::uint32_t i = 0; i < 3; ++i)
    for (std::uint32_t j = 0; j < 3; ++j) {
      mapping::LinkPair pair{i, j, inliers, two_metres_each(j)};
      pair.T_a_b.t_10um[0] -= two_metres_each(i).t_10um[0];
      link.pairs.push_back(pair);
    }
  return link;
}

}  // namespace onemap::test
