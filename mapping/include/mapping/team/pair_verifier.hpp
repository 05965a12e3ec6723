#pragma once
#include <functional>
#include <optional>

#include "mapping/team/agreement.hpp"
#include "mapping/team/own_places.hpp"
#include "mapping/team/pair_schedule.hpp"
#include "mapping/team/patience.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::mapping {

// Looks at the pairs of chains that are this robot's to look at, when they are due, the greatest gain first: of its
// present life those with higher ids, and those with lower ones that are earlier lives, or gone, or let the team wait
// for long. The others' keyframes ask this robot's places. Used by one thread.
class PairVerifier {
 public:
  // interval: see PairSchedule; patience: with a lower robot that lives and does not look.
  PairVerifier(const VerifyConfig& config, OwnPlaces& places, Duration interval, Duration patience)
      : config_(config), schedule_(interval), patience_(patience), places_(places) {}

  struct Look {
    LinkRecord link;
    bool news = false;  // the link has to be written
  };
  // Looks at one pair; nothing when none is due, or when stop() said true in between.
  std::optional<Look> next(const Agreement& team, Instant now, const std::function<bool()>& stop);
  void took(Duration cost);  // the last look

 private:
  std::optional<std::vector<CloudPair>> pairs(const RobotId& self, const TeamMember& own, const KeyframeSource& foreign,
                                              bool own_first, const std::function<bool()>& stop);
  bool mine(const Agreement& team, const ChainId& other, Instant now);
  std::optional<Look> look(const Agreement& team, const ChainId& other, Instant now, const std::function<bool()>& stop);

  const VerifyConfig config_;
  PairSchedule schedule_;
  Patience<ChainId> patience_;
  std::optional<ChainId> last_, own_;
  OwnPlaces& places_;
};

}  // namespace onemap::mapping
