#pragma once
#include <map>
#include <set>

#include "daemon/radio.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

// Who holds the same global map, while robots map and after: a robot agrees with this one while it says a digest that
// this one's map had lately. It may be a moment ahead or behind, so each has a while. Robots that are gone, or of
// whom there is a beacon and no Hello, are not asked. Used by one thread.
class MapAgreement {
 public:
  void look(const TeamView& team, const RadioView& radio, Instant now);

  bool agreed() const { return agreed_; }                         // with everybody who lives
  const std::set<RobotId>& differing() const { return differ_; }  // with whom not, of those

 private:
  std::map<RobotId, Instant> matched_;  // when it last did
  std::set<RobotId> differ_;
  bool agreed_ = false;
};

}  // namespace onemap::daemon
