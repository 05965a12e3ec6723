#include "mapping/team/own_places.hpp"

#include <utility>

namespace onemap::mapping {

KeyframeSource keyframes_of(const RobotId& robot, const TeamMember& member) {
  return {robot, member.keyframes.size(), [&member](std::size_t i) {
            if (member.keyframes[i] == nullptr) return KeyframeRecord{};
            auto keyframe = decode_keyframe(member.keyframes[i]->body);
            return keyframe ? std::move(*keyframe) : KeyframeRecord{};
          }};
}

PlaceIndex& OwnPlaces::up_to_date(const RobotId& self, const TeamMember& own) {
  if (life_ != own.incarnation || keyframes_ > own.keyframes.size()) {
    index_.clear();
    keyframes_ = gone_ = 0;
    every_ = 1;
  }
  life_ = own.incarnation;
  for (; keyframes_ < own.keyframes.size(); ++keyframes_) {
    if (own.keyframes[keyframes_] == nullptr) continue;
    const auto keyframe = decode_keyframe(own.keyframes[keyframes_]->body);
    if (keyframe) put_in({self, own.incarnation, keyframes_}, *keyframe);
  }
  for (; gone_ < own.keyframes.gone().size(); ++gone_)
    index_.remove({self, own.incarnation, own.keyframes.gone()[gone_]});
  return index_;
}

void OwnPlaces::put_in(const PlaceId& id, const KeyframeRecord& keyframe) {
  const std::vector<BinaryFeature> features = binary_features(keyframe);
  while (index_.keyframes() > 0 && id.keyframe % every_ == 0 && !index_.has_room(features.size())) thin(id);
  if (id.keyframe % every_ == 0) index_.insert(id, keyframe.descriptor_kind, features);
}

// Those before `id`.
void OwnPlaces::thin(PlaceId id) {
  every_ *= 2;
  for (std::uint32_t end = std::exchange(id.keyframe, 0); id.keyframe < end; ++id.keyframe)
    if (id.keyframe % every_ != 0) index_.remove(id);
}

}  // namespace onemap::mapping
