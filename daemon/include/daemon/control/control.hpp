#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "daemon/config.hpp"
#include "daemon/control/control_actions.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/metrics_port.hpp"
#include "daemon/control/robot_facts.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/feed.hpp"

namespace onemap::daemon {

// The daemon's control: the socket, the optional TCP ports, and what clients hear unasked. open() and close() belong to
// the loop's thread; pose() and event() are for other threads, and work (for nothing) after close(), too.
class Control {
 public:
  struct Sources {
    std::function<RobotFacts()> facts;  // without those of the control itself
    std::function<std::optional<mapping::Pose>(const PoseNow&)> map_correction;
  };
  Control(EventLoop& loop, Sources sources, ControlActions actions, Log& log);

  // A socket that was asked for and cannot be had is an error, and so is a service's; where nobody asked, it is said
  // and done without.
  Status open(const Config& config, const std::string& version);
  void close();
  void pose(const PoseNow& pose);
  void event(const mapping::TeamEvent& event);
  const std::string& place() const { return place_; }  // of the socket; empty: there is none

 private:
  Status serve(const Config& config);
  Status open_feeds();
  std::vector<Command> commands();
  RobotFacts facts() const;
  void tell_poses();
  void tell_events();
  void look();

  EventLoop& loop_;
  const Sources sources_;
  const ControlActions actions_;
  Log& log_;
  std::string place_;
  std::unique_ptr<ControlServer> server_;
  std::unique_ptr<MetricsPort> metrics_;
  std::optional<EventLoop::Bell> pose_bell_, event_bell_;
  Feed<PoseNow> poses_;
  Feed<Json> events_;
  std::atomic<bool> poses_wanted_ = false;
};

}  // namespace onemap::daemon
