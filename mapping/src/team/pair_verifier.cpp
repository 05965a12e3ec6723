#include "mapping/team/pair_verifier.hpp"

#include <utility>

#include "mapping/records/keyframe.hpp"

namespace onemap::mapping {

namespace {

// Members keep only keyframes that decode.
KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member) {
  return {robot, member.keyframes.size(), [&member](std::size_t i) {
            auto keyframe = decode_keyframe(member.keyframes[i]->body);
            return keyframe ? std::move(*keyframe) : KeyframeRecord{};
          }};
}

PairSchedule::Keyframes count(const Agreement& team, const RobotId& robot, const TeamMember& member) {
  return {member.incarnation, member.keyframes.size(), team.keyframes_here(robot)};
}

}  // namespace

// The keyframes that came since the last time.
void PairVerifier::index(const RobotId& self, const TeamMember& own) {
  if (indexed_life_ != own.incarnation || indexed_keyframes_ > own.keyframes.size()) {
    places_.clear();
    indexed_keyframes_ = 0;
  }
  indexed_life_ = own.incarnation;
  for (; indexed_keyframes_ < own.keyframes.size(); ++indexed_keyframes_) {
    const auto keyframe = decode_keyframe(own.keyframes[indexed_keyframes_]->body);
    if (!keyframe) continue;
    places_.insert({self, own.incarnation, indexed_keyframes_}, keyframe->descriptor_kind, binary_features(*keyframe));
  }
}

// Clouds of the pair's first robot with clouds of its second.
std::optional<std::vector<CloudPair>> PairVerifier::pairs(const KeyframeSource& own, const KeyframeSource& foreign,
                                                          bool own_first, const std::function<bool()>& stop) {
  auto found = config_.find_pairs == FindPairs::all_pairs ? match_all_pairs(own, foreign, stop)
                                                          : ask_index(places_, foreign, stop);
  if (found && !own_first)
    for (CloudPair& pair : *found) std::swap(pair.r, pair.s);
  return found;
}

bool PairVerifier::mine(const Agreement& team, const RobotId& other, Instant now) {
  const RobotId& self = team.log().self();
  const auto verifier = team.verifier(self, other);
  const bool owed =
      verifier == other && team.keyframes_here(self) && team.keyframes_here(other) && !team.verified(self, other);
  return patience_.exhausted(other, owed, now) || verifier == self;
}

std::optional<PairVerifier::Look> PairVerifier::next(const Agreement& team, Instant now,
                                                     const std::function<bool()>& stop) {
  const RobotId& self = team.log().self();
  const TeamMember* own = team.log().find(self);
  if (own == nullptr) return std::nullopt;
  for (const RobotId& other : team.robots()) {
    const TeamMember* theirs = team.log().find(other);
    if (other == self || theirs == nullptr || !mine(team, other, now)) continue;
    if (schedule_.due(count(team, self, *own), other, count(team, other, *theirs), now))
      return look(team, other, now, stop);
  }
  return std::nullopt;
}

std::optional<PairVerifier::Look> PairVerifier::look(const Agreement& team, const RobotId& other, Instant now,
                                                     const std::function<bool()>& stop) {
  const RobotId& self = team.log().self();
  const TeamMember &own = *team.log().find(self), &theirs = *team.log().find(other);
  const KeyframeSource ours = keyframes_of(self, own), foreign = keyframes_of(other, theirs);
  const bool lower = self < other;
  if (config_.find_pairs == FindPairs::by_index) index(self, own);
  auto candidates = pairs(ours, foreign, lower, stop);
  if (!candidates) return std::nullopt;
  auto link = verify_robots(lower ? ours : foreign, lower ? foreign : ours, std::move(*candidates), config_, stop);
  if (!link) return std::nullopt;
  link->incarnation_other = theirs.incarnation;
  const bool linked = link->reason == LinkReason::accepted;
  const PairSchedule::Keyframes have = count(team, self, own), they_have = count(team, other, theirs);
  // While mapping, a refusal is only news when it takes a link back.
  const bool news = (have.all && they_have.all) || linked || schedule_.linked(other, theirs.incarnation);
  schedule_.verified(have, other, they_have, linked, now);
  last_ = other;
  return Look{*link, news};
}

void PairVerifier::took(Duration cost) {
  if (last_) schedule_.took(*last_, cost);
}

}  // namespace onemap::mapping
