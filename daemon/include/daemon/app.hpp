#pragma once
#include <memory>

#include "daemon/capture.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/options.hpp"
#include "daemon/outputs.hpp"
#include "daemon/pipeline.hpp"
#include "daemon/radio.hpp"
#include "daemon/report.hpp"
#include "daemon/signals.hpp"
#include "daemon/status.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

// One robot: camera -> capture -> pipeline -> records -> radio and team -> outputs. The parts start in this order's
// reverse, so that nobody speaks to somebody who is not there yet, and stop in this order.
class App {
 public:
  App(Config config, Log& log);

  // From the camera's opening to the last file; returns what the program exits with.
  Exit run(StopSignals& signals);

 private:
  Status open();
  void start();
  bool work_until_done(StopSignals& signals);  // false: stopped before
  void stop();
  void tick();
  bool done() const;
  bool agreed() const;
  bool peers_awaited() const;
  RobotStatus status() const;
  Report report() const;
  Status write_all();
  Status write_trajectories() const;
  std::vector<MapPicture> pictures() const;
  MapPicture global_picture() const;

  const Config config_;
  Log& log_;
  std::unique_ptr<hal::DepthCamera> camera_;
  std::uint64_t frames_expected_ = 0;
  std::unique_ptr<Team> team_;    // not there when the robot is alone
  std::unique_ptr<Radio> radio_;  // not there when the robot is alone
  std::unique_ptr<Capture> capture_;
  std::unique_ptr<Pipeline> pipeline_;  // takes from the capture's queue, so it goes first
  Instant finished_at_{}, agreed_at_{}, status_at_{};
  bool finished_ = false, agreed_ = false;
  double peak_rss_mb_ = 0;
};

}  // namespace onemap::daemon
