#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>

#include "daemon/team_map.hpp"
#include "daemon/worker.hpp"

namespace onemap::daemon {

// The team thread: applies everybody's records to the TeamMap and does its work, however long a piece takes; neither
// the frame path nor the radio waits for it.
class Team {
 public:
  Team(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config, Publish publish, Failures& failures,
       Log& log);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  void start();
  void stop();                                       // within two seconds, whatever is being done
  void apply(std::shared_ptr<const Record> record);  // from the radio; the store bounds how much can wait
  void begin_life(std::uint64_t incarnation);
  void presence(const std::map<RobotId, Instant>& last_sign, const std::set<RobotId>& records_complete);
  TeamView view() const;
  const TeamMap& map() const { return map_; }  // after stop()

 private:
  void run();
  std::vector<std::shared_ptr<const Record>> wait_for_records();
  Failures& failures_;
  TeamMap map_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<const Record>> inbox_;
  TeamView view_;
  std::atomic<bool> stopping_ = false;
  Worker thread_;
};

}  // namespace onemap::daemon
