#pragma once
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "comms/record.hpp"
#include "daemon/log.hpp"
#include "daemon/outgoing.hpp"
#include "mapping/team/atlas.hpp"
#include "mapping/team/records.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::daemon {

struct TeamMapConfig {
  mapping::AtlasConfig atlas;
  mapping::VerifyConfig verify;
};

// Where the team stands, as this robot knows it.
struct TeamView {
  std::uint64_t robots_known = 0, robots_finished = 0, robots_in_map = 0;
  bool settled = false;      // all known robots' records are here, verified, solved, and fused
  std::uint64_t digest = 0;  // of the global map; 0: none yet
  Duration merge{};          // from the last robot's Finished record to the global map
};

// One robot of the team by its records. Keyframes and submaps stay encoded; they are decoded while they are worked on.
struct TeamMember {
  std::uint64_t incarnation = 0;  // of the life that these records are from: the newest one heard of
  std::string name, camera;
  std::optional<mapping::FinishedRecord> finished;
  std::vector<std::shared_ptr<const comms::Record>> keyframes, submaps;
  std::vector<mapping::StampedPose> poses;
  std::vector<mapping::QuantizedPose> keyframe_poses;
  std::optional<mapping::SolutionRecord> solution;  // the last one that it published

  bool keyframes_complete() const { return finished && keyframes.size() >= finished->keyframes; }
  bool complete() const {
    return keyframes_complete() && submaps.size() >= finished->submaps && poses.size() >= finished->tracked;
  }
};

// The team's map from everybody's records (the paper, section 4). Which robot does what follows from the records alone:
// of each pair the lower id verifies, the lowest id of all decides (publishes the Solution), and everyone fuses the
// Solution of the lowest id that published one. Used by one thread.
class TeamMap {
 public:
  TeamMap(const RobotId& self, const TeamMapConfig& config, Publish publish, Log& log);

  // A record that comms applied: any robot's, this one's too; each log in order.
  void apply(const std::shared_ptr<const comms::Record>& record, Instant now);
  // Does the next piece of work that the records allow; false when there is none. Pieces take up to seconds.
  bool step();
  // After a step: looks whether the map became settled.
  void observe(Instant now);

  TeamView view() const;
  const std::map<RobotId, TeamMember>& members() const { return members_; }
  const std::optional<mapping::SolutionRecord>& solution() const { return fused_; }  // of the global map
  const mapping::VoxelMap* map() const { return fused_ ? &atlas_->map() : nullptr; }
  std::uint64_t refused_records() const { return refused_; }

 private:
  using Pair = std::pair<RobotId, RobotId>;
  TeamMember* member_of(const comms::LogId& log);  // nullptr: of an earlier life
  Status decode_into(TeamMember& member, const std::shared_ptr<const comms::Record>& record);
  Status add_link(const RobotId& author, std::span<const std::uint8_t> body);
  bool verify_next_pair();
  bool decide();
  bool fuse();
  std::vector<RobotId> robots() const;  // with a Hello record
  bool all_finished() const;
  bool all_linked() const;
  const mapping::SolutionRecord* current_solution() const;
  std::optional<mapping::SolutionRecord> wanted_solution() const;
  std::size_t submaps_in(const mapping::SolutionRecord& solution) const;
  void log_fused() const;

  const RobotId self_;
  const TeamMapConfig config_;
  Publish publish_;
  Log& log_;
  std::map<RobotId, TeamMember> members_;
  std::map<Pair, mapping::LinkRecord> links_;
  std::set<Pair> verified_;  // by this robot
  std::optional<mapping::SolutionRecord> published_;
  std::unique_ptr<mapping::Atlas> atlas_;  // made for the first solution
  std::optional<mapping::SolutionRecord> fused_;
  std::size_t fused_submaps_ = 0;
  bool all_finished_seen_ = false;
  Instant all_finished_at_{};
  Instant fused_at_{};
  bool fused_anew_ = false;  // since the last observe()
  bool settled_ = false;
  std::uint64_t digest_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace onemap::daemon
