#pragma once
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/log.hpp"
#include "daemon/map_fusion.hpp"
#include "daemon/outgoing.hpp"
#include "daemon/pair_schedule.hpp"
#include "daemon/team_member.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::daemon {

// Why a link was refused, for people; "accepted" otherwise.
const char* link_words(mapping::LinkReason reason);

struct TeamMapConfig {
  mapping::AtlasConfig atlas;
  mapping::VerifyConfig verify;
  Duration lost_after = std::chrono::seconds(60);
  Duration merge_while_mapping{};  // at most so often while robots map; zero: only when all have finished
};

// What is waited for, of whom, and for how long that robot has been silent.
struct Waiting {
  enum class What { records, end, link, solution };
  RobotId robot;
  What what = What::records;
  Duration silent{};
};

// Where the team stands, as this robot knows it.
struct TeamView {
  std::uint64_t robots_known = 0, robots_finished = 0, robots_in_map = 0;
  bool settled = false;      // all known robots' records are here, verified, solved, and fused
  std::uint64_t digest = 0;  // of the last global map; 0: none yet
  std::vector<Waiting> waiting;
  std::set<RobotId> gone;
  Duration merge{};  // from the last robot's Finished record to the global map
};

// Records that could not be used, of one kind.
struct RefusedRecords {
  std::uint64_t count = 0;
  std::string last_reason;
};

// The team's map from everybody's records (the paper, section 4). Which robot does what follows from the records alone:
// of each pair the lower id verifies, the lowest id of all decides (publishes the Solution), and everyone fuses the
// Solution of the lowest id that published one. What is concluded while robots still map is replaced by what is
// concluded from all records, so in the end equal record sets give equal maps. Used by one thread.
class TeamMap {
 public:
  using Stop = std::function<bool()>;
  TeamMap(const RobotId& self, const TeamMapConfig& config, Publish publish, Log& log);

  // A record that comms applied: any robot's, this one's too; each log in order.
  void apply(const std::shared_ptr<const Record>& record, Instant now);
  // Does the next piece of work that the records allow; false when there is none. Pieces take up to seconds; they end
  // early, with nothing done, when stop() says true.
  bool step(
      Instant now, const Stop& stop = [] { return false; });
  // After a step: looks whether the map became settled.
  void observe(Instant now);
  // At the end: finishes the map that was being built, from the records that there are, unless stop() says true before.
  void finish_fusion(const Stop& stop);

  TeamView view() const;
  const std::map<RobotId, TeamMember>& members() const { return members_; }
  // Of the global map; nothing while it is being built.
  std::optional<mapping::SolutionRecord> solution() const;
  const mapping::VoxelMap* map() const { return fusion_.map(); }
  std::vector<mapping::LinkRecord> links() const;                                      // that count, sorted by pair
  const std::map<std::uint16_t, RefusedRecords>& refused() const { return refused_; }  // by kind

 private:
  using Pair = std::pair<RobotId, RobotId>;
  TeamMember* member_of(const LogId& log);  // nullptr: of an earlier life
  Status take(TeamMember& member, const std::shared_ptr<const Record>& record);
  Status take_link(const RobotId& author, std::span<const std::uint8_t> body);
  void log_member(const RobotId& id, const TeamMember& member, std::uint16_t kind) const;
  void log_link(const mapping::LinkRecord& link) const;
  bool verify_next_pair(Instant now, const Stop& stop);
  bool verify(const RobotId& other, Instant now, const Stop& stop);
  bool decide();
  bool fuse(Instant now, const Stop& stop);
  bool may_begin(const mapping::SolutionRecord& solution, Instant now) const;
  void fused();
  std::vector<RobotId> robots() const;  // with a Hello record
  bool all_finished() const;
  const mapping::LinkRecord* link_of(const RobotId& a, const RobotId& b) const;  // of their present lives
  bool all_linked() const;                                                       // from all keyframes
  const mapping::SolutionRecord* current_solution() const;
  std::optional<mapping::SolutionRecord> wanted_solution() const;  // from all records
  std::optional<mapping::SolutionRecord> interim_solution() const;
  std::size_t submaps_in(const mapping::SolutionRecord& solution) const;

  const RobotId self_;
  const TeamMapConfig config_;
  Publish publish_;
  Log& log_;
  std::map<RobotId, TeamMember> members_;
  std::map<Pair, mapping::LinkRecord> links_;  // the last one of each pair
  PairSchedule schedule_;
  std::optional<mapping::SolutionRecord> published_;
  MapFusion fusion_;
  bool stale_ = false;               // a robot in the map started anew
  Instant next_interim_fusion_{};    // not before
  std::uint64_t robots_in_map_ = 0;  // of the last map
  std::uint64_t digest_ = 0;
  bool all_finished_seen_ = false;
  Instant all_finished_at_{}, fused_at_{};
  bool fused_anew_ = false;  // since the last observe()
  bool settled_ = false;
  std::map<std::uint16_t, RefusedRecords> refused_;
};

}  // namespace onemap::daemon
