#include "mapping/team/agreement.hpp"

#include <algorithm>

#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

Agreement::Agreement(const TeamLog& log, const Presence& presence, Instant now)
    : log_(log), presence_(presence), now_(now), robots_(log.robots()) {
  for (const RobotId& robot : robots_)
    if (presence_.gone(robot, member(robot), now_)) gone_.insert(robot);
}

const TeamMember& Agreement::member(const RobotId& robot) const {
  static const TeamMember nobody;
  const TeamMember* found = log_.find(robot);
  return found != nullptr ? *found : nobody;
}

bool Agreement::over() const {
  return std::ranges::all_of(
      robots_, [&](const RobotId& robot) { return member(robot).finished.has_value() || gone_.contains(robot); });
}

// What others have of a robot that is gone would have come: its records are signs of life. One that lives may have
// promised more than it wrote: when all that is known of is here, and nothing came for long, that was it.
bool Agreement::nothing_more_comes(const RobotId& robot) const {
  if (gone_.contains(robot)) return true;
  const TeamMember& m = member(robot);
  return m.finished && presence_.all_known_here(robot) && presence_.quiet(m, now_);
}

bool Agreement::keyframes_here(const RobotId& robot) const {
  return member(robot).keyframes_complete() || nothing_more_comes(robot);
}

bool Agreement::all_here(const RobotId& robot) const { return member(robot).complete() || nothing_more_comes(robot); }

std::optional<RobotId> Agreement::verifier(const RobotId& a, const RobotId& b) const {
  const auto& [low, high] = std::minmax(a, b);
  if (!gone_.contains(low)) return low;
  if (!gone_.contains(high)) return high;
  return std::nullopt;
}

bool Agreement::verified(const RobotId& a, const RobotId& b) const {
  if (!keyframes_here(a) || !keyframes_here(b)) return false;
  const auto& [low, high] = std::minmax(a, b);
  if (member(low).keyframes.empty() || member(high).keyframes.empty() || !verifier(low, high)) return true;
  const LinkRecord* link = link_between(log_, low, high);
  return link != nullptr && covers(*link, member(low), member(high));
}

// A robot that lives and writes nothing for long has not looked, and is not waited for: the map is right without.
bool Agreement::looked_at_own(const RobotId& robot) const {
  const TeamMember& m = member(robot);
  const auto is_anchor = [](const KeyframePlace& place) { return place.anchor == place.index; };
  if (std::ranges::count_if(m.places, is_anchor) < 2 || gone_.contains(robot)) return true;
  const LinkRecord* loops = own_loops(m, robot);
  return (loops != nullptr && covers(*loops, m, m)) || (robot != log_.self() && presence_.quiet(m, now_));
}

bool Agreement::ready() const {
  if (robots_.empty() || !over()) return false;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (!keyframes_here(robots_[i]) || !looked_at_own(robots_[i])) return false;
    for (std::size_t j = i + 1; j < robots_.size(); ++j)
      if (!verified(robots_[i], robots_[j])) return false;
  }
  return true;
}

Duration Agreement::silent(const RobotId& robot) const { return presence_.silent(robot, member(robot), now_); }

std::optional<Waiting::What> Agreement::owes(const RobotId& robot) const {
  if (!member(robot).finished && !gone_.contains(robot)) return Waiting::What::end;
  if (!all_here(robot)) return Waiting::What::records;
  if (keyframes_here(robot) && !looked_at_own(robot)) return Waiting::What::link;
  for (const RobotId& other : robots_)
    if (other != robot && keyframes_here(other) && verifier(robot, other) == robot && !verified(robot, other))
      return Waiting::What::link;
  return std::nullopt;
}

std::vector<Waiting> Agreement::waiting() const {
  std::vector<Waiting> out;
  for (const RobotId& robot : robots_)
    if (robot != log_.self())
      if (const auto what = owes(robot)) out.push_back({robot, *what, silent(robot)});
  return out;
}

}  // namespace onemap::mapping
