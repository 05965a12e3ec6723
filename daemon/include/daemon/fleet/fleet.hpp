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
// stops them, and collects what they wrote into OUT/report.json.
class Fleet {
 public:
  // daemon_program: the path of onemapd.
  Fleet(FleetConfig config, std::string daemon_program);
  Exit run(StopSignals& signals);

 private:
  enum class End { agreed, out_of_time, stopped, robot_ended };
  Status start();
  Status start_robot(std::size_t number);
  End wait_until_agreed(StopSignals& signals);
  bool stop_robots();  // true: every robot ended with status 0
  void read_statuses();
  bool all_agree() const;
  Result<Report> collect() const;
  Status write_truth(std::size_t number) const;
  void print_result(const Report& report) const;
  std::string folder(std::size_t number) const { return config_.out + "/" + fleet_robot_name(number); }

  const FleetConfig config_;
  const std::string daemon_program_;
  std::unique_ptr<LinkEmulator> links_;
  std::vector<ChildProcess> robots_;
  std::vector<RobotStatus> statuses_;
};

// Joins the robots' own reports: equal digests, the reference that they name, the slowest merge.
Report join_reports(const std::vector<Report>& robots, bool all_agreed);

}  // namespace onemap::daemon
