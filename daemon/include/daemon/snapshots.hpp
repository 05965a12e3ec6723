#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/map_copy.hpp"
#include "daemon/map_drawing.hpp"
#include "daemon/pictures.hpp"
#include "daemon/snapshot_folder.hpp"
#include "daemon/worker.hpp"

namespace onemap::daemon {

class Team;

// What somebody wants; words as in snapshots.views, .kinds and .maps.
struct SnapshotWish {
  std::vector<std::string> views, kinds, maps;
};
SnapshotWish default_wish(const SnapshotsConfig& config);

struct SnapshotsView {
  bool busy = false;
  std::uint64_t made = 0, failed = 0;
  std::uint64_t coalesced = 0;  // asked for while another one was waiting, which was left out for it
  std::uint64_t killed = 0;     // drawings that took too much or too long
  std::uint64_t removed = 0;    // old ones
  std::uint64_t finished = 0;   // number of the last request that was worked on; those before it were, or left out
  std::string folder, error;    // of that one: where it is, or why not
  double took_s = 0;            // it
  double copy_ms = 0;           // of that, how long the team's thread stood still
};

// Snapshots of the maps while the robot works: pictures and models drawn by onemap-view as a child with limits, and the
// floor plan, each time a new folder below OUT/snapshots that is there whole or not at all (SnapshotFolder); map.pgm
// and map.yaml in OUT, too. Global files are global_VIEW.png and global.glb, own ones local_VIEW.png and local.glb; a
// robot alone has one map, its local one. One job at a time, on a thread of low priority; the newest request wins. What
// the team's thread gives for it is a copy of the map (MapCopy). A failure is counted and said; the next one may
// succeed. Thread safe.
class Snapshots {
 public:
  // A copy of the map; nothing when stop() said true before there was one.
  using Take = std::function<std::optional<MapCopy>(const std::function<bool()>& stop)>;

  // config must outlive it. limits: of one drawing.
  Snapshots(const Config& config, Take take, Failures& failures, Log& log, PictureLimits limits = snapshot_limits());
  ~Snapshots();
  Snapshots(const Snapshots&) = delete;
  Snapshots& operator=(const Snapshots&) = delete;

  void start();
  void stop();  // what is being drawn is left off
  // The number of the request: once view().finished is at least that, it was worked on, or left out for a newer one.
  std::uint64_t request(SnapshotWish wish);
  // The main thread, now and then: asks when it is time, or when the map has changed, as the configuration says.
  void tick(Instant now, std::uint64_t map_digest);
  SnapshotsView view() const;

  static PictureLimits snapshot_limits();

 private:
  struct Job {
    std::uint64_t number = 0;
    SnapshotWish wish;
  };
  struct Made {
    std::string folder;
    double copy_ms = 0;
  };
  void run();
  std::optional<Job> next();
  Result<Made> make(const SnapshotWish& wish);
  Status fill(const std::string& folder, const MapSource& from, const SnapshotWish& wish);
  std::vector<MapPicture> pictures(const std::string& folder, const MapSource& from, const SnapshotWish& wish) const;
  Result<bool> draw(const MapPicture& picture);
  void note(const Job& job, const Result<Made>& made, Duration took);

  const Config& config_;
  const Take take_;
  Failures& failures_;
  Log& log_;
  PictureLimits limits_;
  SnapshotFolder folder_;
  std::atomic<bool> stopping_ = false;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable wake_;
  std::optional<Job> waiting_;
  std::uint64_t requests_ = 0;
  SnapshotsView view_;
  // The main thread's:
  std::optional<Instant> due_;
  Instant changed_at_{};
  std::uint64_t drawn_digest_ = 0;
  Worker thread_;
};

// The team's map when there is one, within a few seconds; else its records alone.
Snapshots::Take take_from(Team& team);

}  // namespace onemap::daemon
