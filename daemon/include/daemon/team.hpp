#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "daemon/team_map.hpp"

namespace onemap::daemon {

// The team thread: applies everybody's records to the TeamMap and does its work, however long a piece takes; neither
// the frame path nor the radio waits for it.
class Team {
 public:
  Team(const RobotId& self, const TeamMapConfig& config, Publish publish, Log& log);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  void start();
  void stop();                                       // within two seconds, whatever is being done
  void apply(std::shared_ptr<const Record> record);  // from the radio; the store bounds how much can wait
  TeamView view() const;
  const TeamMap& map() const { return map_; }  // after stop()

 private:
  void run();
  std::vector<std::shared_ptr<const Record>> wait_for_records();
  TeamMap map_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<const Record>> inbox_;
  TeamView view_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace onemap::daemon
