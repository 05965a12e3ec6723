#pragma once
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mapping/records/kind.hpp"
#include "mapping/team/agreement.hpp"
#include "mapping/team/decision.hpp"
#include "mapping/team/loop_finder.hpp"
#include "mapping/team/map_fusion.hpp"
#include "mapping/team/map_up.hpp"
#include "mapping/team/needless_keyframes.hpp"
#include "mapping/team/needless_submaps.hpp"
#include "mapping/team/own_places.hpp"
#include "mapping/team/pair_verifier.hpp"
#include "mapping/team/presence.hpp"
#include "mapping/team/spare_records.hpp"
#include "mapping/team/team_event.hpp"
#include "mapping/team/team_log.hpp"
#include "mapping/team/team_solver.hpp"
#include "mapping/team/why.hpp"

namespace onemap::mapping {

struct TeamMapConfig {
  AtlasConfig atlas;
  VerifyConfig verify;
  PlaceIndexConfig places;                         // of this robot's keyframes
  Duration lost_after = std::chrono::seconds(60);  // a robot that was silent for so long is not waited for
  // While robots map, pairs are looked at, and what was found is told, at most so often; zero: only when all have
  // finished, and until then there is no map.
  Duration merge_while_mapping{};
  Duration map_interval = std::chrono::seconds(1);  // while robots map, the map gets what is new at most so often
  // Where the bodies of applied records can be read again until take_spare() names them as unread; then voxels, most of
  // what a team says, are not held in memory. Empty: they are. Called by the thread that uses the map.
  ReadRecord read_again;
};

// Where the team stands, as this robot knows it.
struct TeamView {
  std::uint64_t robots_known = 0, robots_finished = 0, robots_in_map = 0;
  bool settled = false;          // all that will come of all robots is here, verified, solved, and fused
  std::uint64_t digest = 0;      // of the last global map; 0: none yet
  std::vector<Waiting> waiting;  // for the final map, of others
  std::set<RobotId> greeted;     // whose present lives count: with a valid Hello
  std::set<RobotId> gone;        // silent for too long, so not waited for
  std::set<RobotId> cut_short;   // of those, the ones of which a part is missing for good
  std::map<RobotId, std::uint32_t> keyframes_in_map;  // of the last global map: of each robot's present life
  std::uint64_t blocks = 0, blocks_refused = 0;       // of the last global map; refused: it was full
  std::uint64_t places_left_out = 0;                  // own keyframes that are not in the place index, thinned as it is
  std::uint64_t submaps_left_out = 0;                 // of the last global map: more than may be decoded
  std::uint64_t submaps_unread = 0;                   // of it: there as they were, for a body cannot be read
  std::uint64_t blocks_unplaced = 0;                  // of the last global map: hung on an anchor nobody knows
  std::uint64_t needless = 0;                         // own voxel records that were found needless, in all
  std::uint64_t needless_keyframes = 0;               // and own keyframes
  std::uint64_t unthinned = 0;                        // own voxel records that came since needless ones were looked for
  std::uint64_t records_refused = 0, submaps_refused = 0;  // malformed or not its author's to write; and of these
  Duration merge{};                                        // from the end of the last robot's work to the global map
  std::vector<std::uint64_t> digests;                      // of the last global maps, at most 32, the newest last
  // From this robot's odometry to the global map, where it is now; nothing while it is not in the map.
  std::optional<QuantizedPose> T_map_odometry;
  std::uint32_t chain = 0;  // so many chains has this robot ended before the present one, since it was started
};

// Records that could not be used, of one kind.
struct RefusedRecords {
  std::uint64_t count = 0;
  std::string last_reason;
};

// The team's map from everybody's records (the paper, section 4): the parts of this folder put together. Which robot
// does what follows from the records: each looks for its own loops, of each pair the lower id verifies, one elected
// robot decides (solves the pose graph and publishes the Solution), and everyone fuses what was decided once it is what
// the links say. While robots map, the elected one also says now and then how far everybody's records count (the
// Frontier); who holds these has the same map as it. Once all have finished, the map is what follows from all records,
// so equal record sets give equal maps. A robot that is gone is not waited for, and the next one does its work. Used by
// one thread.
class TeamMap {
 public:
  using Stop = std::function<bool()>;
  TeamMap(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config);

  // A record that comms applied: any robot's, this one's too; each log in order.
  void apply(const RecordPtr& record, Instant now);
  void begin_life(std::uint64_t incarnation, bool repeats);  // see TeamLog
  // When each robot was last known to live, and of whom every record that is known of is here.
  void presence(std::map<RobotId, Instant> last_sign, std::set<RobotId> records_complete);
  // Does the next piece of work that the records allow; false when there is none. Pieces take up to seconds; they end
  // early, with nothing done, when stop() says true.
  bool step(
      Instant now, const Stop& stop = [] { return false; });
  void took(Duration cost);  // the last step: rare work is done for a tenth of the time at most
  // After a step: looks where the team stands.
  void observe(Instant now);
  // At the end: finishes the map that was being built, from the records that there are, unless stop() says true before.
  void finish_fusion(const Stop& stop);

  // Why the two are in one map, or are not. One robot twice: its lives and own loops. The error names who is unknown.
  Result<Why> why(const RobotId& a, const RobotId& b) const;
  // A person takes back what joins the two (unmerge: their links do not count from now on, and unless others join them
  // the maps part), or takes that back (merge). One robot twice: its lives, and its present life's own loops. A later
  // life is judged anew. How many pairs of lives that is about; the error says why it is about none. Works once the
  // records that it writes are applied, in every robot alike.
  Result<std::size_t> unmerge(const RobotId& a, const RobotId& b) { return rule(a, b, true); }
  Result<std::size_t> merge(const RobotId& a, const RobotId& b) { return rule(a, b, false); }

  std::vector<TeamRecord> take_records() { return std::exchange(records_, {}); }  // to be written by this robot
  SpareRecords take_spare() { return std::exchange(spare_, {}); }
  std::vector<TeamEvent> take_events() { return std::exchange(events_, {}); }

  const TeamView& view() const { return view_; }
  const std::map<ChainId, TeamMember>& members() const { return log_.members(); }
  const TeamLog& log() const { return log_; }
  const SolutionRecord* solution() const {
    return fusion_.solution();
  }  // of the global map; nullptr: it is being built
  const VoxelMap* map() const { return fusion_.map(); }
  std::string graph() const;              // the pose graph under it as g2o text; empty while there is no map
  std::vector<LinkRecord> links() const;  // that count, sorted by pair
  const std::map<std::uint16_t, RefusedRecords>& refused() const { return refused_; }  // by kind

 private:
  enum class Work { none, verified, solved, fused, thinned_voxels, thinned_keyframes };
  // A pass over all own records of a kind for what later ones have made needless.
  struct Thinning {
    Instant next{};           // not before, unless many came since
    std::size_t records = 0;  // there were at the last one
    bool begin(Instant now, std::size_t there, std::size_t many);
  };
  void refuse(const RecordId& id, std::uint16_t kind, const std::string& reason);
  void tell(const Record& record, bool first_hello);
  bool find_loops(const Agreement& team, Instant now, const Stop& stop);
  bool verify(const Agreement& team, Instant now, const Stop& stop);
  // The final one, or while robots map one of robots that are linked, or of one alone.
  bool map_is_due(const Agreement& team) const;
  bool decide(const Agreement& team, Instant now);
  bool decide_now(const Agreement& team, Instant now);
  bool say_frontier(Instant now);
  Result<std::size_t> rule(const RobotId& a, const RobotId& b, bool apart);
  bool publish(SolutionRecord solution);
  std::optional<MapTarget> target(const Agreement& team);
  bool all_here(const Agreement& team, const SolutionRecord& solution) const;
  void take_aim(const Agreement& team, Instant now);
  bool fuse(const Agreement& team, Instant now, const Stop& stop);
  void fused();
  bool look_for_needless(Instant now);
  void thin_voxels(const TeamMember& own, const SolvedRobot& solved);
  void thin_keyframes(const TeamMember& own, const SolvedRobot& solved);
  void tell_fused(bool final);
  void note_end(const Agreement& team, Instant now);
  void note_links();
  void note_gone(const Agreement& team);
  void update_view(const Agreement& team);

  const RobotId self_;
  const TeamMapConfig config_;
  TeamLog log_;
  Presence presence_;
  OwnPlaces places_;
  LoopFinder loops_;
  PairVerifier verifier_;
  std::map<ChainId, LinkRecord> unwritten_;  // the last look at pairs of this life's, by the other, that was no news
  TeamSolver solver_;
  MapUp up_;
  Decision decision_;
  std::optional<SolutionRecord> published_;
  bool say_again_ = false;   // this life has not said it yet: what an earlier one said counts no longer
  FrontierRecord frontier_;  // the last one published
  MapFusion fusion_;
  NeedlessSubmaps needless_;
  NeedlessKeyframes needless_keyframes_;
  Thinning voxels_thinned_, keyframes_thinned_;
  SpareRecords spare_;
  std::set<RecordId> malformed_;                             // submaps that were to be fused
  Instant next_solve_{}, next_frontier_{}, next_aim_{};      // not before, while robots map
  std::uint64_t solved_revision_ = 0;                        // of the log
  bool final_ = false;                                       // what is fused is from all that will come
  std::optional<std::pair<std::uint64_t, Instant>> told_{};  // the solution of the last map that was told, and when
  Instant now_{};                                            // of this step
  Work worked_ = Work::none;                                 // the last step
  bool over_ = false;                                        // as last looked
  bool linked_once_ = false;                                 // two chains were joined by a link
  Instant over_at_{}, fused_at_{};
  bool fused_anew_ = false;  // since the last observe()
  std::optional<std::uint64_t> told_settled_;
  std::vector<TeamRecord> records_;
  std::vector<TeamEvent> events_;
  std::map<std::uint16_t, RefusedRecords> refused_;
  TeamView view_;
};

}  // namespace onemap::mapping
