#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "daemon/cameras.hpp"
#include "daemon/capture.hpp"
#include "daemon/config.hpp"
#include "daemon/control/control.hpp"
#include "daemon/control/output_actions.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/harvest.hpp"
#include "daemon/kept_map.hpp"
#include "daemon/log.hpp"
#include "daemon/map_agreement.hpp"
#include "daemon/map_keeper.hpp"
#include "daemon/options.hpp"
#include "daemon/pipeline.hpp"
#include "daemon/pose_streams.hpp"
#include "daemon/radio.hpp"
#include "daemon/recorder.hpp"
#include "daemon/service.hpp"
#include "daemon/signals.hpp"
#include "daemon/snapshots.hpp"
#include "daemon/standing.hpp"
#include "daemon/status.hpp"
#include "daemon/team.hpp"
#include "daemon/worker.hpp"
#include "hal/backends/libusb/usb_watch.hpp"

namespace onemap::daemon {

// One robot, in a team or alone (then it is a team of one, without a socket): camera -> capture -> pipeline -> records
// -> radio and team -> outputs. The parts start in this order's reverse, so that nobody speaks to somebody who is not
// there yet, and stop in this order. The main thread turns one event loop: signals, timers, control.
class App {
 public:
  App(Config config, Log& log, std::span<const hal::Backend> cameras = camera_backends());

  // From the camera's opening to the last file; returns what the program exits with.
  Exit run(StopSignals& signals);
  // What SIGHUP does while it works, on the main thread; without it SIGHUP stops. Before run().
  void on_reload(std::function<void()> reload) { reload_ = std::move(reload); }
  // Main thread, while it runs: takes over what can change, says what cannot, and why a configuration is not taken.
  void reload(const Result<Config>& loaded);

 private:
  enum class End { done, stopped, failed };
  Status open_camera();
  Status open_rest();
  Status open_control();
  RobotFacts facts() const;
  Status open_team();
  OutgoingRecord greeting() const;
  void start();
  bool quick() const { return asked_to_stop_ && config_.quick_stop; }
  Status open_loop(StopSignals& signals);
  void take_signals(StopSignals& signals);
  End work();
  void stop();
  void open_kept_map();
  void keep_map(const Harvest& harvest);
  void await_map();
  Exit verdict(End end, const Status& written);
  Exit failed_to_start(const Error& error);
  void tick();
  void note_status(const Status& written);
  Status open_poses();
  void tell_pose(const PoseNow& pose);
  void watch(Instant now);
  void watch_usb();
  void hear_usb(Instant now);
  void take_standing(Instant now);
  void say_waiting(Instant now);
  bool done() const;
  bool lingered(Instant now) const;
  DaemonStatus status() const;

  Config config_;  // after the start only the main thread writes it, and only what no other reads (reload.hpp)
  Log& log_;
  const std::span<const hal::Backend> cameras_;
  std::function<void()> reload_;
  Service service_;
  std::unique_ptr<EventLoop> loop_;
  std::unique_ptr<Control> control_;  // threads tell it what happens, so it outlives them
  Instant began_{};
  Failures failures_;
  std::unique_ptr<hal::DepthCamera> camera_;
  CameraFacts camera_facts_;  // as it was opened: from then on it is the capture thread's, which knows its words
  std::uint64_t frames_expected_ = 0;
  std::unique_ptr<hal::UsbWatch> usb_watch_;  // where the camera is live and this machine tells
  std::unique_ptr<Team> team_;
  std::unique_ptr<Radio> radio_;
  std::optional<PoseStreams> pose_streams_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Capture> capture_;
  std::unique_ptr<Snapshots> snapshots_;
  std::unique_ptr<OutputActions> output_actions_;  // uses the recorder and the snapshots
  std::unique_ptr<Pipeline> pipeline_;             // takes from the capture's queue, so it goes first
  Standing standing_;
  MapAgreement map_agreement_;
  Instant finished_at_{}, agreed_at_{}, stuck_at_{}, status_at_{}, said_at_{}, holes_at_{};
  bool finished_ = false, asked_to_stop_ = false, status_written_ = true;
  std::optional<KeptMap> kept_map_;
  std::unique_ptr<MapKeeper> map_keeper_;
  double peak_rss_mb_ = 0;
};

}  // namespace onemap::daemon
