#include "mapping/team/own_places.hpp"

#include <utility>

namespace onemap::mapping {

KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member) {
  return {robot, member.keyframes.size(), [&member](std::size_t i) {
            auto keyframe = decode_keyframe(member.keyframes[i]->body);
            return keyframe ? std::move(*keyframe) : KeyframeRecord{};
          }};
}

PlaceIndex& OwnPlaces::up_to_date(const RobotId& self, const TeamMember& own) {
  if (life_ != own.incarnation || keyframes_ > own.keyframes.size()) {
    index_.clear();
    keyframes_ = 0;
  }
  life_ = own.incarnation;
  for (; keyframes_ < own.keyframes.size(); ++keyframes_) {
    const auto keyframe = decode_keyframe(own.keyframes[keyframes_]->body);
    if (!keyframe) continue;
    index_.insert({self, own.incarnation, keyframes_}, keyframe->descriptor_kind, binary_features(*keyframe));
  }
  return index_;
}

}  // namespace onemap::mapping
