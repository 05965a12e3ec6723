#include "mapping/team/pair_verifier.hpp"

#include <utility>
namespace onemap::mapping {

namespace {

PairSchedule::Keyframes count(const Agreement& team, const ChainId& chain, const TeamMember& member) {
  return {member.keyframes.size(), team.keyframes_here(chain)};
}

}  // namespace

// Clouds of the pair's first robot with clouds of its second.
std::optional<std::vector<CloudPair>> PairVerifier::pairs(const RobotId& self, const TeamMember& own,
                                                          const KeyframeSource& foreign, bool own_first,
                                                          const std::function<bool()>& stop) {
  auto found = config_.find_pairs == FindPairs::all_pairs ? match_all_pairs(keyframes_of(self, own), foreign, stop)
                                                          : ask_index(places_.up_to_date(self, own), foreign, stop);
  if (found && !own_first)
    for (CloudPair& pair : *found) std::swap(pair.r, pair.s);
  return found;
}

bool PairVerifier::mine(const Agreement& team, const ChainId& other, Instant now) {
  const ChainId& self = team.log().own_chain();
  const auto verifier = team.verifier(self, other);
  const bool owed = verifier == other.robot && other.robot != self.robot && team.keyframes_here(self) &&
                    team.keyframes_here(other) && !team.verified(self, other);
  return patience_.exhausted(other, owed, now) || verifier == self.robot;
}

std::optional<PairVerifier::Look> PairVerifier::next(const Agreement& team, Instant now,
                                                     const std::function<bool()>& stop) {
  const ChainId& self = team.log().own_chain();
  const TeamMember* own = team.log().own();
  if (own == nullptr) return std::nullopt;
  if (std::exchange(own_, self) != self) schedule_.clear();
  const PairSchedule::Keyframes have = count(team, self, *own);
  std::optional<std::pair<PairSchedule::Gain, ChainId>> best;
  for (const ChainId& other : team.chains()) {
    const TeamMember* theirs = team.log().find(other);
    if (other == self || theirs == nullptr || team.log().rulings().apart(self, other)) continue;
    if (!mine(team, other, now)) continue;
    const PairSchedule::Keyframes they_have = count(team, other, *theirs);
    if (!schedule_.due(have, other, they_have, now)) continue;
    const PairSchedule::Gain gain = schedule_.gain(have, other, they_have);
    if (!best || gain > best->first) best = {gain, other};
  }
  return best ? look(team, best->second, now, stop) : std::nullopt;
}

std::optional<PairVerifier::Look> PairVerifier::look(const Agreement& team, const ChainId& other, Instant now,
                                                     const std::function<bool()>& stop) {
  const ChainId& self = team.log().own_chain();
  const TeamMember &own = *team.log().own(), &theirs = *team.log().find(other);
  const KeyframeSource ours = keyframes_of(self.robot, own), foreign = keyframes_of(other.robot, theirs);
  const bool lower = self < other;
  auto candidates = pairs(self.robot, own, foreign, lower, stop);
  if (!candidates) return std::nullopt;
  auto link = verify_robots(lower ? ours : foreign, lower ? foreign : ours, std::move(*candidates), config_, stop);
  if (!link) return std::nullopt;
  link->incarnation_other = theirs.incarnation;
  const bool linked = link->reason == LinkReason::accepted, was_linked = schedule_.linked(other);
  const PairSchedule::Keyframes have = count(team, self, own), they_have = count(team, other, theirs);
  schedule_.verified(have, other, they_have, linked, now);
  // While mapping, a refusal is only news when it takes a link back.
  const bool news = (have.all && they_have.all) || linked || (was_linked && !schedule_.linked(other));
  last_ = other;
  return Look{*link, news};
}

void PairVerifier::took(Duration cost) {
  if (last_) schedule_.took(*last_, cost);
}

}  // namespace onemap::mapping
