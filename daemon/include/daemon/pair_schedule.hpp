#pragma once
#include <algorithm>
#include <map>
#include <optional>

#include "daemon/team_member.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

// When this robot looks at which other robot's keyframes: once both are finished and all keyframes are here, always;
// before, at most every `interval` (and for at most a tenth of the time), when the two are not linked yet or their
// keyframes grew by half. Used by one thread.
class PairSchedule {
 public:
  explicit PairSchedule(Duration interval) : interval_(interval) {}  // zero: only at the end

  bool due(const TeamMember& mine, const RobotId& other, const TeamMember& theirs, Instant now) const;
  // The pair was verified with all keyframes that the two have; it took from `began` to `now`.
  void verified(const TeamMember& mine, const RobotId& other, const TeamMember& theirs, bool linked, Instant began,
                Instant now);
  bool linked(const RobotId& other, const TeamMember& theirs) const;  // by the last look at this life of the other

 private:
  struct Look {
    std::uint64_t incarnation = 0;
    std::size_t mine = 0, theirs = 0;  // keyframes looked at
    bool linked = false, final = false;
    Instant next{};  // not again before, unless it is the end
  };
  static constexpr std::size_t kFewest = 3;  // keyframes of each for a look while mapping
  const Look* last_look(const RobotId& other, const TeamMember& theirs) const;

  const Duration interval_;
  std::map<RobotId, Look> looks_;
};

}  // namespace onemap::daemon
