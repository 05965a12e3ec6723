#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "daemon/kept_map.hpp"
#include "daemon/log.hpp"
#include "daemon/worker.hpp"

namespace onemap::daemon {

// Keeps the last settled map on the disk while the robot works, and its floor plan, on a thread of its own and of low
// priority: what takes long (copying the map between two pieces of the team's work, compressing it, a slow disk) is
// waited for there. What cannot be kept is said, and tried again a while later.
class MapKeeper {
 public:
  // Leaves off when stop() says true.
  using Then = std::function<Status(const std::function<bool()>& stop)>;
  struct Saved {
    std::uint64_t digest = 0;
    std::vector<std::uint8_t> bytes;  // of save_map()
    Then then = {};                   // what is made of the same map once it is kept
  };
  // The team's map now; nothing when there is none, or stop() said true before there was one.
  using Take = std::function<std::optional<Saved>(const std::function<bool()>& stop)>;

  MapKeeper(KeptMap& map, Take take, Failures& failures, Log& log)
      : map_(map), take_(std::move(take)), failures_(failures), log_(log) {}
  ~MapKeeper() { stop(); }
  MapKeeper(const MapKeeper&) = delete;
  MapKeeper& operator=(const MapKeeper&) = delete;

  void start();
  void stop();  // what is being written is written; then the KeptMap is the caller's again
  // The main thread, now and then: digest of the team's map, and whether every robot that lives holds it.
  void tick(std::uint64_t digest, bool settled, Instant now);

 private:
  void run();
  void keep();
  KeptMap& map_;  // with mutex_, but while busy_
  const Take take_;
  Failures& failures_;
  Log& log_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool wanted_ = false, busy_ = false;
  std::atomic<bool> stopping_ = false;
  Worker thread_;
};

}  // namespace onemap::daemon
