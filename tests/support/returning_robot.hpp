#pragma once
#include <deque>
#include <set>
#include <utility>
#include <vector>

#include "mapping/local/local_mapper.hpp"
#include "mapping/team/map_fusion.hpp"
#include "mapping/team/team_map.hpp"
#include "support/team_author.hpp"

namespace onemap::test {

constexpr std::size_t kMapBytes = 192u << 20;  // the corridor twice round is more than a daemon's 128 MB

// A robot alone, with its own team map; voxel records name what they make needless, and what remains of keyframes takes
// their places, as the daemon has them do.
class ReturningRobot {
 public:
  explicit ReturningRobot(const hal::Intrinsics& k) : mapper_({}, k) {
    author.hello();
    team.apply(author.written().back(), now_);
  }

  // The next frame, a tenth of a second after the last.
  void see(const hal::FrameView& frame) {
    mapper_.process(frame);
    now_ += std::chrono::milliseconds(100);
    take();
  }
  // What its map has to do.
  void work() {
    for (bool busy = true; busy;) {
      busy = team.step(now_);
      team.observe(now_);
      for (mapping::TeamRecord& record : team.take_records()) write(record.lane, record.kind, std::move(record.body));
    }
    const mapping::SpareRecords spare = team.take_spare();
    needless_.insert(needless_.end(), spare.needless.begin(), spare.needless.end());
    unread.insert(spare.unread.begin(), spare.unread.end());
    for (const mapping::KeyframeRemains& remains : spare.keyframes) {
      author.replacing(remains.of.seq);
      write(mapping::Lane::features, mapping::RecordKind::keyframe, remains.body);
    }
  }
  const mapping::TeamView& view() {
    team.observe(now_);
    return team.view();
  }
  void finish() {
    mapper_.finish();
    take();
    work();
  }

  Author author{"a"};
  mapping::TeamMap team{author.id(), 1, config()};
  std::set<RecordId> unread;  // whose bodies may go

 private:
  static mapping::TeamMapConfig config() {
    mapping::TeamMapConfig out;
    out.merge_while_mapping = std::chrono::seconds(10);
    out.map_interval = std::chrono::seconds(10);
    out.atlas.map.budget_bytes = kMapBytes;
    return out;
  }
  void write(mapping::Lane lane, mapping::RecordKind kind, std::vector<std::uint8_t> body) {
    if (kind == mapping::RecordKind::submap && !needless_.empty()) {
      author.replacing(needless_.front().seq);
      needless_.pop_front();
    }
    team.apply(author.write(lane, static_cast<std::uint16_t>(kind), std::move(body)), now_);
  }
  void take() {
    mapping::KeyframeRecord keyframe;
    while (mapper_.take_keyframe(keyframe))
      write(mapping::Lane::features, mapping::RecordKind::keyframe, mapping::encode(keyframe));
    mapping::TrajectoryRecord poses;
    while (mapper_.take_poses(poses))
      write(mapping::Lane::poses, mapping::RecordKind::trajectory, mapping::encode(poses));
    mapping::SubmapRecord submap;
    while (mapper_.take_submap(submap))
      write(mapping::Lane::voxels, mapping::RecordKind::submap, mapping::encode(submap));
  }

  mapping::LocalMapper mapper_;
  Instant now_{std::chrono::seconds(1000)};
  std::deque<RecordId> needless_;
};

// The digest and the number of blocks of the map that a solution makes of a log's records.
inline std::pair<std::uint64_t, std::size_t> fused(const mapping::TeamLog& log,
                                                   const mapping::SolutionRecord& solution) {
  mapping::MapFusion fusion(kMapBytes);
  fusion.aim(log, {solution, everything_here(log, solution)});
  while (fusion.underway())
    if (!fusion.step([] { return false; })) throw std::runtime_error("the map does not go on");
  if (fusion.map()->used() == fusion.map()->capacity()) throw std::runtime_error("the map has no room");
  return {fusion.digest(), fusion.map()->used()};
}

}  // namespace onemap::test
