#include "mapping/team/agreement.hpp"

#include <algorithm>

#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

Agreement::Agreement(const TeamLog& log, const Presence& presence, Instant now)
    : log_(log), presence_(presence), now_(now), robots_(log.robots()), chains_(log.chains()) {
  for (const RobotId& robot : robots_)
    if (presence_.gone(robot, member(robot), now_)) gone_.insert(robot);
}

const TeamMember& Agreement::member(const ChainId& chain) const {
  static const TeamMember nobody;
  const TeamMember* found = log_.find(chain);
  return found != nullptr ? *found : nobody;
}

bool Agreement::present(const ChainId& chain) const {
  return log_.present(chain.robot) == chain && !gone_.contains(chain.robot);
}

bool Agreement::over() const {
  return std::ranges::all_of(
      robots_, [&](const RobotId& robot) { return member(robot).finished.has_value() || gone_.contains(robot); });
}

// What others have of a robot that is gone, or of an earlier life, would have come: its records are signs of life. One
// that lives may have promised more than it wrote: when all that is known of is here, and nothing came for long, that
// was it.
bool Agreement::nothing_more_comes(const ChainId& chain) const {
  if (gone_.contains(chain.robot)) return true;
  const TeamMember& m = member(chain);
  const bool known_here = presence_.all_known_here(chain.robot), quiet = presence_.quiet(m, now_);
  return present(chain) ? m.finished && known_here && quiet : known_here || quiet;
}

bool Agreement::keyframes_here(const ChainId& chain) const {
  return member(chain).keyframes_complete() || nothing_more_comes(chain);
}

bool Agreement::all_here(const ChainId& chain) const { return member(chain).complete() || nothing_more_comes(chain); }

std::optional<RobotId> Agreement::verifier(const ChainId& a, const ChainId& b) const {
  const auto& [low, high] = std::minmax(a, b);
  if (present(low)) return low.robot;
  if (present(high)) return high.robot;
  return std::nullopt;
}

bool Agreement::verified(const ChainId& a, const ChainId& b) const {
  if (!keyframes_here(a) || !keyframes_here(b)) return false;
  const auto& [low, high] = std::minmax(a, b);
  if (log_.rulings().apart(low, high)) return true;  // whatever would be found
  if (member(low).keyframes.empty() || member(high).keyframes.empty() || !verifier(low, high)) return true;
  const LinkRecord* link = link_between(log_, low, high);
  return link != nullptr && covers(*link, member(low), member(high));
}

// A robot that lives and writes nothing for long has not looked, and is not waited for: the map is right without.
bool Agreement::looked_at_own(const RobotId& robot) const {
  const TeamMember& m = member(robot);
  const auto is_anchor = [](const KeyframePlace& place) { return place.anchor == place.index; };
  if (std::ranges::count_if(m.keyframes.places(), is_anchor) < 2 || gone_.contains(robot)) return true;
  const LinkRecord* loops = own_loops(m, robot);
  return (loops != nullptr && covers(*loops, m, m)) || (robot != log_.self() && presence_.quiet(m, now_));
}

bool Agreement::ready() const {
  if (robots_.empty() || !over()) return false;
  for (const RobotId& robot : robots_)
    if (!looked_at_own(robot)) return false;
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    if (!keyframes_here(chains_[i])) return false;
    for (std::size_t j = i + 1; j < chains_.size(); ++j)
      if (!verified(chains_[i], chains_[j])) return false;
  }
  return true;
}

Duration Agreement::silent(const RobotId& robot) const { return presence_.silent(robot, member(robot), now_); }

std::optional<Waiting::What> Agreement::owes(const RobotId& robot) const {
  const ChainId chain = log_.present(robot);
  if (!member(chain).finished && !gone_.contains(robot)) return Waiting::What::end;
  for (const ChainId& life : chains_)
    if (life.robot == robot && !all_here(life)) return Waiting::What::records;
  if (keyframes_here(chain) && !looked_at_own(robot)) return Waiting::What::link;
  for (const ChainId& other : chains_)
    if (other != chain && keyframes_here(other) && verifier(chain, other) == robot && !verified(chain, other))
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
