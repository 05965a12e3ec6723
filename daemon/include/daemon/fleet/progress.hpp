#pragma once
#include <string>
#include <vector>

#include "daemon/status.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// Shows what the robots are doing: bars that are redrawn on a terminal, a plain line now and then elsewhere (stderr).
class Progress {
 public:
  Progress(std::vector<std::string> names, bool terminal) : names_(std::move(names)), terminal_(terminal) {}
  void show(const std::vector<DaemonStatus>& robots, Instant now, bool last = false);

  // A line such as `robot1  [#####-----]  52 %  412/789 tracked 411  merging`.
  static std::string bar(const std::string& name, const DaemonStatus& robot);

 private:
  void redraw(const std::vector<DaemonStatus>& robots);
  void print_line(const std::vector<DaemonStatus>& robots) const;
  const std::vector<std::string> names_;
  const bool terminal_;
  bool drawn_ = false;
  Instant shown_{};
};

}  // namespace onemap::daemon
