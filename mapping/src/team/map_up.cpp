#include "mapping/team/map_up.hpp"

#include <algorithm>

#include "mapping/records/keyframe.hpp"
#include "mapping/team/level_frame.hpp"
#include "mapping/team/way_on_map.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kKeyframesLooked = 64;  // keyframes: a decoded one takes half a millisecond

Vector3f cameras_up(std::span<const PlacedKeyframe> keyframes) {
  Vector3d sum = Vector3d::Zero();
  for (const PlacedKeyframe& keyframe : keyframes) sum -= keyframe.T_map_keyframe.R.col(1);
  if (!(sum.norm() > 0.1 * static_cast<double>(keyframes.size())) || !sum.allFinite()) return {0, -1, 0};
  return sum.normalized().cast<float>();
}

std::size_t keyframes_here(const TeamLog& log, const SolutionRecord& solution) {
  std::size_t count = 0;
  for (const SolvedRobot& solved : solution.robots)
    if (const TeamMember* member = log.find(solved.chain)) count += member->keyframes.size();
  return count;
}

UpDirection look(const TeamLog& log, const SolutionRecord& solution) {
  return up_direction(up_of_keyframes(placed_keyframes(log, solution), kKeyframesLooked));
}

}  // namespace

std::vector<PlacedKeyframe> placed_keyframes(const TeamLog& log, const SolutionRecord& solution) {
  std::vector<PlacedKeyframe> placed;
  for (const SolvedRobot& solved : solution.robots) {
    const TeamMember* member = log.find(solved.chain);
    if (member == nullptr) continue;
    for (const KeyframeOnMap& keyframe : keyframes_on_map(*member, solved))
      if (const RecordPtr& record = member->keyframes[keyframe.position]; record != nullptr)
        placed.push_back({record->body, from_quantized(keyframe.T_map_keyframe)});
  }
  return placed;
}

Vector3f up_of_keyframes(std::span<const PlacedKeyframe> keyframes, std::size_t most) {
  std::vector<Facet> facets;
  const std::size_t step = std::max<std::size_t>((keyframes.size() + most - 1) / std::max<std::size_t>(most, 1), 1);
  for (std::size_t i = 0; i < keyframes.size(); i += step)
    if (const auto record = decode_keyframe(keyframes[i].body))
      add_facets(record->grid, keyframes[i].T_map_keyframe, facets);
  return up_of(facets, cameras_up(keyframes));
}

UpDirection MapUp::final(const TeamLog& log, const SolutionRecord& solution) {
  if (!final_ || final_->revision != log.revision()) final_ = {log.revision(), look(log, solution)};
  return final_->up;
}

UpDirection MapUp::now(const TeamLog& log, const SolutionRecord& solution, const SolutionRecord* in_use) {
  const std::size_t here = keyframes_here(log, solution);
  const bool same_frame = in_use != nullptr && in_use->reference == solution.reference;
  if (same_frame && looked_at_ > 0 && 2 * here < 3 * looked_at_) return in_use->up;
  looked_at_ = here;
  return look(log, solution);
}

}  // namespace onemap::mapping
