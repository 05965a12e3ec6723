#pragma once
#include <memory>
#include <string>
#include <vector>

#include "daemon/fleet/child_process.hpp"
#include "daemon/fleet/fleet_options.hpp"
#include "daemon/fleet/link_emulator.hpp"
#include "daemon/fleet/progress.hpp"
#include "daemon/report.hpp"
#include "daemon/signals.hpp"
#include "daemon/status.hpp"

namespace onemap::daemon {

// A team of real daemons on this machine: starts them with the link emulator between them, waits until all agree,
// stops them, and collects what they wrote into OUT/report.json. A robot that ends by itself ends the team: the others
// are stopped and write what they have, and the report says which robot failed.
class Fleet {
 public:
  // daemon_program: the path of onemapd.
  Fleet(FleetConfig config, std::string daemon_program);
  Exit run(StopSignals& signals);

 private:
  enum class End { agreed, out_of_time, stopped, robot_ended };
  struct Robot {
    ChildProcess process;
    std::string failed;  // how it ended, if not well
  };
  Status start();
  Status start_robot(std::size_t number);
  Status clear_folder(std::size_t number) const;
  End wait_until_agreed(StopSignals& signals);
  bool any_ended();
  void stop_robots();
  void say_failed(std::size_t number) const;
  void read_statuses();
  bool all_agree() const;
  Report collect(bool agreed) const;
  Report robot_report(std::size_t number) const;
  Exit verdict(End end, const Report& report) const;
  Status write_truth(std::size_t number) const;
  std::string folder(std::size_t number) const { return config_.out + "/" + fleet_robot_name(number); }

  const FleetConfig config_;
  const std::string daemon_program_;
  std::unique_ptr<LinkEmulator> links_;
  std::vector<Robot> robots_;
  std::vector<DaemonStatus> statuses_;
};

// Joins the robots' own reports: equal digests, the reference that they name, the slowest merge.
Report join_reports(const std::vector<Report>& robots, bool all_agreed);

// For people: the table, what the team came to, and the files that are there.
std::string to_text(const Report& report, const std::string& out);

}  // namespace onemap::daemon
