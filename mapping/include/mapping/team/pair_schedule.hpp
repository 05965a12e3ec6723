#pragma once
#include <map>

#include "hal/base/time.hpp"
#include "mapping/records/chain_id.hpp"

namespace onemap::mapping {

// When this robot looks at which other chain's keyframes: once all that will come of both are here, with all of them;
// before, at most every `interval` (and for at most a tenth of the time, all chains together for a third), when the two
// are not linked yet or their keyframes grew by half. Refused once, a link is in doubt and still there: it is looked at
// again with the next keyframe, and gone when it is refused again. Used by one thread.
class PairSchedule {
 public:
  struct Keyframes {  // of one chain
    std::size_t here = 0;
    bool all = false;  // no more will come
  };
  explicit PairSchedule(Duration interval) : interval_(interval) {}  // zero: only at the end

  void clear() { looks_.clear(); }  // this robot's own chain is another one
  bool due(const Keyframes& mine, const ChainId& other, const Keyframes& theirs, Instant now) const;
  // What a look may bring, the greater the more: a link that is not there, then keyframes that were not looked at.
  struct Gain {
    bool link = false;
    std::size_t keyframes = 0;
    auto operator<=>(const Gain&) const = default;
  };
  Gain gain(const Keyframes& mine, const ChainId& other, const Keyframes& theirs) const;
  // The pair was verified with the keyframes that are here.
  void verified(const Keyframes& mine, const ChainId& other, const Keyframes& theirs, bool linked, Instant now);
  void took(const ChainId& other, Duration cost);  // so long did that last
  bool linked(const ChainId& other) const;         // by the last look, or in doubt

 private:
  struct Look {
    std::size_t mine = 0, theirs = 0;  // keyframes looked at
    bool linked = false, doubted = false, final = false;
    Instant at{}, next{};  // not again before `next`, unless it is the end
  };
  static constexpr std::size_t kFewest = 3;  // keyframes of each for a look while mapping
  const Look* last_look(const ChainId& other) const;

  const Duration interval_;
  Instant next_{};  // at any chain that is not at its end
  std::map<ChainId, Look> looks_;
};

}  // namespace onemap::mapping
