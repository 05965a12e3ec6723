#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "daemon/heartbeat.hpp"
#include "daemon/link_tally.hpp"
#include "daemon/log.hpp"
#include "daemon/outgoing.hpp"
#include "daemon/worker.hpp"
#include "mapping/team/team_map.hpp"

namespace onemap::daemon {

using mapping::TeamMapConfig;
using mapping::TeamView;
using mapping::Waiting;

// The team thread: applies everybody's records to the TeamMap and does its work, however long a piece takes; neither
// the frame path nor the radio waits for it. What happens in the team goes into the log from here.
class Team {
 public:
  Team(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config, Publish publish, Failures& failures,
       Log& log);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  // Told of everything that happens in the team, on the team's thread: must be quick. Before start().
  void on_event(std::function<void(const mapping::TeamEvent&)> told) { told_ = std::move(told); }
  // Given the voxel records that make room, on the team's thread: must be quick. Before start().
  void on_spare(std::function<void(mapping::SpareRecords)> given) { given_ = std::move(given); }
  void start();
  // Whatever is being done; the map that was being built gets so long.
  static constexpr Duration kForTheMap = std::chrono::milliseconds(1500);
  void stop(Duration for_the_map = kForTheMap);
  void apply(std::shared_ptr<const Record> record);  // from the radio, which asks first whether there is room
  static constexpr std::size_t kInboxBytes = 8u << 20;
  bool has_room() const;  // fewer bytes than that wait to be applied, in bodies
  // For who makes records as fast as it can: waits, a second at most, while many own voxel records are not yet looked
  // at for what they make needless, so that memory does not depend on how fast the processor is.
  void catch_up();
  static constexpr std::size_t kMostUnthinned = 160;  // some 8 MB
  // From the radio: this robot goes on under this number. repeats: its records come again, and those of the life before
  // do not count.
  void begin_life(std::uint64_t incarnation, bool repeats);
  // Any thread: when each robot was last known to live, and of whom every record that is known of is here.
  void presence(const std::map<RobotId, Instant>& last_sign, const std::set<RobotId>& records_complete);
  TeamView view() const;
  const Heartbeat& heartbeat() const { return heartbeat_; }
  LinkTally links() const;  // any thread
  // Any thread: calls question(map) on the team's thread, between two pieces of its work, which take up to seconds;
  // again and again until it says that it is answered. It must be quick: the team's work waits. What has not been
  // called when the thread ends never is.
  using Question = std::function<bool(mapping::TeamMap&)>;
  void ask(Question question);
  const mapping::TeamMap& map() const { return map_; }  // after stop()

 private:
  struct Inbox {
    std::vector<std::shared_ptr<const Record>> records;
    std::size_t bytes = 0;                                   // of their bodies
    std::optional<std::pair<std::uint64_t, bool>> new_life;  // before those of the records that are of it; repeats
    std::map<RobotId, Instant> last_sign;
    std::set<RobotId> records_complete;
    bool presence = false;
    std::vector<Question> questions;
    bool empty() const { return records.empty() && !new_life && questions.empty(); }
  };
  void run();
  Inbox take(bool wait);
  void apply_all(Inbox inbox, Instant arrived);
  void hand_out();
  void show();
  void answer();

  Failures& failures_;
  Log& log_;
  const Publish publish_;
  std::function<void(const mapping::TeamEvent&)> told_;
  std::function<void(mapping::SpareRecords)> given_;
  mapping::TeamMap map_;
  mutable std::mutex mutex_;  // of inbox_, view_ and links_
  std::condition_variable wake_, caught_up_;
  Inbox inbox_;
  TeamView view_;
  LinkTally links_;
  std::vector<Question> open_;  // the thread's own
  std::atomic<bool> stopping_ = false;
  std::atomic<std::int64_t> for_the_map_ns_ = Duration(kForTheMap).count();
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
