#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// Our end of systemd's notification protocol (sd_notify(3)): datagrams of KEY=VALUE lines to the Unix socket that the
// environment names. Without one every call does nothing and succeeds.
class ServiceManager {
 public:
  struct Environment {
    std::string socket;        // NOTIFY_SOCKET: a path, or an abstract name after '@'
    std::string watchdog_us;   // WATCHDOG_USEC
    std::string watchdog_pid;  // WATCHDOG_PID: whom the watchdog is for; empty: anybody
  };
  static Environment environment();

  // What is wrong with the environment is the error of every call.
  explicit ServiceManager(const Environment& environment);
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  bool present() const { return !address_.empty(); }
  // Within so long the next alive() must come, or the service is killed and started again. Nothing: it is not watched.
  std::optional<Duration> watchdog() const { return watchdog_; }

  Status ready();                         // the camera and the sockets are up; also after reloading()
  Status reloading(Instant now);          // SIGHUP came
  Status stopping();                      // nobody is waited for any more
  Status alive();                         // feeds the watchdog
  Status say(std::string_view one_line);  // what `systemctl status` shows

 private:
  Status send(const std::string& text) const;
  std::string address_;  // as the kernel has it: a path, or '\0' and a name
  Error wrong_;
  int socket_ = -1;
  std::optional<Duration> watchdog_;
};

}  // namespace onemap::daemon
