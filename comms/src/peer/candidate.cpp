#include "peer/candidate.hpp"

#include <algorithm>

namespace onemap::comms {

namespace {
bool is_due(const Candidate& candidate) { return candidate.beacon_due || candidate.ping_due; }
}  // namespace

void Candidates::greeted(Instant now, const RobotId& robot, std::uint64_t life, bool names_us, SplitMix& random) {
  Candidate* const place = place_of(now, robot, life);
  if (place == nullptr) return;
  if (place->robot != robot || place->incarnation != life) *place = {robot, life, 0, false, false, {}};
  if (!names_us) {
    place->beacon_due = true;
    return;
  }
  place->ping_due = true;
  if (place->token != 0) return;
  place->token = static_cast<std::uint32_t>(random.next() >> 32) | 1u;
  place->stays_until = now + kNamedStays;  // and no longer: who is there has answered by then
}

Candidate* Candidates::place_of(Instant now, const RobotId& robot, std::uint64_t life) {
  for (Candidate& place : places_)
    if (place.incarnation == life && place.robot == robot) return &place;
  for (Candidate& place : places_)
    if (place.incarnation == 0) return &place;
  for (std::size_t i = 0; i < kMost; ++i) {
    Candidate& place = places_[turn_++ % kMost];
    if (place.stays_until <= now) return &place;
  }
  return nullptr;
}

const Candidate* Candidates::proved(std::uint64_t life, std::uint32_t token) const {
  const auto at = std::ranges::find_if(places_, [&](const Candidate& place) {
    return place.incarnation != 0 && place.incarnation == life && place.token != 0 && place.token == token;
  });
  return at == places_.end() ? nullptr : &*at;
}

bool Candidates::due() const { return std::ranges::any_of(places_, is_due); }

Candidate* Candidates::next() {
  const auto at = std::ranges::find_if(places_, is_due);
  return at == places_.end() ? nullptr : &*at;
}

}  // namespace onemap::comms
