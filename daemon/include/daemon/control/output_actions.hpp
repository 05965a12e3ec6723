#pragma once
#include <atomic>
#include <deque>
#include <functional>
#include <string>

#include "daemon/config.hpp"
#include "daemon/control/control_actions.hpp"
#include "daemon/control/log_actions.hpp"
#include "daemon/job_thread.hpp"
#include "daemon/recorder.hpp"
#include "daemon/snapshots.hpp"

namespace onemap::daemon {

// SNAPSHOT, RECORD, SAVE and LOAD: what takes long is done by a thread of its own. Paths from outside are names of
// files below OUT, and nothing else of the machine.
class OutputActions {
 public:
  // All must outlive it.
  OutputActions(const Config& config, Snapshots& snapshots, Recorder& recorder, Snapshots::Take take,
                OwnRecords records);

  void add_to(ControlActions& actions);
  void tick();                   // the loop's thread, often: answers for what is done
  void stop() { jobs_.stop(); }  // before what it uses

 private:
  struct Waiting {
    std::uint64_t number = 0;
    Later later;
  };
  void snapshot(const Json& request, const Later& later);
  void record(const Json& request, const Later& later);
  void save(const Json& request, const Later& later);
  void load(const Json& request, const Later& later);
  void work(const Later& later, std::function<Result<Json>(const std::atomic<bool>& stopping)> job);

  const Config& config_;
  Snapshots& snapshots_;
  Recorder& recorder_;
  const Snapshots::Take take_;
  const OwnRecords records_;
  std::deque<Waiting> waiting_;  // snapshots, in order
  JobThread jobs_{"control jobs"};
};

// OUT/NAME, of a request's `path`; the error says why that is no name below OUT. otherwise: when it has none.
Result<std::string> path_below(const std::string& out, const Json& request, const std::string& otherwise);

}  // namespace onemap::daemon
