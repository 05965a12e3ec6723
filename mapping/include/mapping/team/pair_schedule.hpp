#pragma once
#include <map>

#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"

namespace onemap::mapping {

// When this robot looks at which other robot's keyframes: once all that will come of both are here, with all of them;
// before, at most every `interval` (and for at most a tenth of the time), when the two are not linked yet or their
// keyframes grew by half. Used by one thread.
class PairSchedule {
 public:
  struct Keyframes {  // of one robot
    std::uint64_t incarnation = 0;
    std::size_t here = 0;
    bool all = false;  // no more will come
  };
  explicit PairSchedule(Duration interval) : interval_(interval) {}  // zero: only at the end

  bool due(const Keyframes& mine, const RobotId& other, const Keyframes& theirs, Instant now) const;
  // The pair was verified with the keyframes that are here.
  void verified(const Keyframes& mine, const RobotId& other, const Keyframes& theirs, bool linked, Instant now);
  void took(const RobotId& other, Duration cost);                      // so long did that last
  bool linked(const RobotId& other, std::uint64_t incarnation) const;  // by the last look at this life of the other

 private:
  struct Look {
    std::uint64_t incarnation = 0;
    std::size_t mine = 0, theirs = 0;  // keyframes looked at
    bool linked = false, final = false;
    Instant at{}, next{};  // not again before `next`, unless it is the end
  };
  static constexpr std::size_t kFewest = 3;  // keyframes of each for a look while mapping
  const Look* last_look(const RobotId& other, std::uint64_t incarnation) const;

  const Duration interval_;
  std::map<RobotId, Look> looks_;
};

}  // namespace onemap::mapping
