#pragma once
#include <cstdint>

#include "mapping/team/candidates.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// A member's keyframes by their positions in its log, each decoded when it is loaded; without features where nothing
// that it saw can be read.
KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member);

// This robot's keyframes in a place index, by their positions in its log. When it is full, every second one of those
// that are in goes, and of the later ones every second comes in; then every fourth, and so on: a robot that works for
// hours still finds all its places, by fewer views of each. Used by one thread.
class OwnPlaces {
 public:
  explicit OwnPlaces(const PlaceIndexConfig& config) : index_(config) {}

  // With all keyframes that are here; of another life all anew.
  PlaceIndex& up_to_date(const RobotId& self, const TeamMember& own);
  const PlaceIndex& index() const { return index_; }
  std::size_t left_out() const { return keyframes_ - index_.keyframes(); }  // keyframes that are not in

 private:
  void put_in(const PlaceId& id, const KeyframeRecord& keyframe);
  void thin(PlaceId id);

  PlaceIndex index_;
  std::uint64_t life_ = 0;       // whose
  std::uint32_t keyframes_ = 0;  // so many of them were looked at
  std::size_t gone_ = 0;         // so many of those whose views went were taken out
  std::uint32_t every_ = 1;      // of these every so manyth is in
};

}  // namespace onemap::mapping
