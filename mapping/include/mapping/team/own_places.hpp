#pragma once
#include <cstdint>

#include "mapping/team/candidates.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// A member's keyframes, each decoded when it is loaded. Members keep only keyframes that decode.
KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member);

// This robot's keyframes in a place index, by their positions in its log. Used by one thread.
class OwnPlaces {
 public:
  explicit OwnPlaces(const PlaceIndexConfig& config) : index_(config) {}

  // With all keyframes that are here; of another life all anew.
  PlaceIndex& up_to_date(const RobotId& self, const TeamMember& own);
  const PlaceIndex& index() const { return index_; }

 private:
  PlaceIndex index_;
  std::uint64_t life_ = 0;       // whose
  std::uint32_t keyframes_ = 0;  // so many of them were put in, or refused
};

}  // namespace onemap::mapping
