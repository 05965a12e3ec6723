#pragma once
#include <span>
#include <string>

#include "daemon/heartbeat.hpp"
#include "daemon/log.hpp"
#include "daemon/service_manager.hpp"
#include "daemon/status.hpp"

namespace onemap::daemon {

// What `systemctl status` shows of a robot.
std::string status_line(const DaemonStatus& status);

// What the service manager hears of the daemon: when it is ready, how it stands, and that it gets on, which is said
// only while every thread's heart beats. For the main thread. What cannot be told is logged, and the work goes on.
class Service {
 public:
  explicit Service(Log& log, const ServiceManager::Environment& environment = ServiceManager::environment())
      : log_(log), manager_(environment) {}

  void ready() { note(manager_.ready()); }
  void reloading(Instant now) { note(manager_.reloading(now)); }
  void stopping() { note(manager_.stopping()); }
  void failed(const Error& error) { note(manager_.say(error.text())); }
  void show(const DaemonStatus& status, Instant now);  // as often as one likes: a changed line is sent once a second

  // Often: well within half the watchdog's time. Feeds it if no heart is stuck; else says once whose is. When it was
  // not called for a while, all were stopped (SIGSTOP, a machine that slept), and patience begins anew.
  void watch(std::span<const Heartbeat* const> hearts, Instant now);

 private:
  void note(const Status& status);
  void say_stuck(const Heartbeat* stuck);
  Log& log_;
  ServiceManager manager_;
  std::string shown_;
  Instant shown_at_{}, fed_at_{}, looked_at_{}, awake_since_{};
  const Heartbeat* stuck_ = nullptr;
};

}  // namespace onemap::daemon
