#pragma once
#include <string>
#include <vector>

#include "daemon/status.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// Shows what the robots are doing: on a terminal a line a robot and one bar for the whole with the time that is left,
// all redrawn; elsewhere a plain line now and then (stderr). No line is wider than kColumns.
class Progress {
 public:
  static constexpr std::size_t kColumns = 100;
  Progress(std::vector<std::string> names, bool terminal, Instant started);
  void show(const std::vector<DaemonStatus>& robots, Instant now, bool last = false);

  // A line such as `robot1     412/789 frames    411 tracked    37 keyframes  merging`.
  static std::string line(const std::string& name, const DaemonStatus& robot, bool colored = false);
  // A line such as `team       [#####-----]  52 %  about 1 min 20 s left`: `elapsed` since the start.
  static std::string bar(const std::vector<DaemonStatus>& robots, Duration elapsed);

 private:
  void redraw(const std::vector<DaemonStatus>& robots, Duration elapsed);
  void print_line(const std::vector<DaemonStatus>& robots) const;
  const std::vector<std::string> names_;
  const bool terminal_, colored_;
  const Instant started_;
  bool drawn_ = false;
  Instant shown_{};
};

}  // namespace onemap::daemon
