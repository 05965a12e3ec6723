#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/hostile.hpp"
#include "sim/run.hpp"
#include "sim/watch.hpp"

namespace onemap::comms::sim {

// One scenario while it is played.
class Play {
 public:
  explicit Play(const Scenario& scenario);
  void tell(const Trace& trace);
  void faults();
  void peace();
  Outcome outcome();

 private:
  // As a daemon: a life's number comes from a clock and is greater than the one before.
  struct Life {
    std::uint64_t number = 0;
    unsigned begun_after_others = 0;
  };
  void at(Duration when, std::function<void()> what);
  void until(Instant when);
  void plan(const Write& write);
  void let_go(std::size_t robot, const Record& record);
  void plan(const Fault& fault);
  void divide(const Fault& fault, bool apart);
  void power_off(const Fault& fault);
  void power_on(const Fault& fault);
  void outlive();  // robots that heard of a later life of theirs begin another, as the daemon does
  void move();
  Duration bound() const;
  Duration latency(std::uint32_t fragments) const;
  void converge(Instant until);
  bool names_taken();
  bool equal() const;  // the honest robots
  std::string why_missing(std::size_t robot) const;
  std::string difference() const;
  bool honest(std::size_t i) const { return i < scenario_.robots; }
  void check();
  void fail(const std::string& what) {
    if (failure_.empty()) failure_ = what;
  }

  const Scenario& scenario_;
  Random random_;
  SimNet net_;
  Watch watch_;
  Field field_;
  std::vector<Life> lives_;
  std::vector<unsigned> off_;  // by so many faults
  std::map<LogId, std::uint32_t> last_that_may_go_;
  Hostile* hostile_ = nullptr;
  std::multimap<Instant, std::function<void()>> plan_;
  std::string failure_;
  Duration recovery_{}, bound_{};
};

}  // namespace onemap::comms::sim
