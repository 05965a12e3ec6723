#pragma once
#include <memory>
#include <span>

#include "daemon/cameras.hpp"
#include "daemon/capture.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/map_agreement.hpp"
#include "daemon/options.hpp"
#include "daemon/pipeline.hpp"
#include "daemon/radio.hpp"
#include "daemon/recorder.hpp"
#include "daemon/signals.hpp"
#include "daemon/snapshots.hpp"
#include "daemon/standing.hpp"
#include "daemon/status.hpp"
#include "daemon/team.hpp"
#include "daemon/worker.hpp"

namespace onemap::daemon {

// One robot, in a team or alone (then it is a team of one, without a socket): camera -> capture -> pipeline -> records
// -> radio and team -> outputs. The parts start in this order's reverse, so that nobody speaks to somebody who is not
// there yet, and stop in this order.
class App {
 public:
  App(Config config, Log& log, std::span<const hal::Backend> cameras = camera_backends());

  // From the camera's opening to the last file; returns what the program exits with.
  Exit run(StopSignals& signals);

 private:
  enum class End { done, stopped, failed };
  Status open_camera();
  Status open_rest();
  Status open_team();
  OutgoingRecord greeting() const;
  void start();
  End work(StopSignals& signals);
  void stop();
  void await_map();
  Exit verdict(End end, const Status& written);
  void tick();
  void note_status(const Status& written);
  void take_standing(Instant now);
  void say_waiting(Instant now);
  bool done() const;
  bool lingered(Instant now) const;
  DaemonStatus status() const;

  const Config config_;
  Log& log_;
  const std::span<const hal::Backend> cameras_;
  Failures failures_;
  std::unique_ptr<hal::DepthCamera> camera_;
  std::uint64_t frames_expected_ = 0;
  std::unique_ptr<Team> team_;
  std::unique_ptr<Radio> radio_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Capture> capture_;
  std::unique_ptr<Snapshots> snapshots_;
  std::unique_ptr<Pipeline> pipeline_;  // takes from the capture's queue, so it goes first
  Standing standing_;
  MapAgreement map_agreement_;
  Instant finished_at_{}, agreed_at_{}, stuck_at_{}, status_at_{}, said_at_{};
  bool finished_ = false, status_written_ = true;
  double peak_rss_mb_ = 0;
};

}  // namespace onemap::daemon
