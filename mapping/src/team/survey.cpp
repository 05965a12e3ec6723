#include "mapping/team/survey.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "mapping/records/keyframe.hpp"
#include "mapping/team/level_frame.hpp"

namespace onemap::mapping {
namespace {

constexpr std::size_t kMostForLevel = 150;  // keyframes in which up and the floor are looked for

// The least step through `count` things that takes at most `most` of them.
std::size_t step_for(std::size_t count, std::size_t most) {
  return count <= most ? 1 : (count + most - 1) / std::max<std::size_t>(most, 1);
}

std::optional<Pose> find_level(std::span<const PlacedKeyframe> keyframes, const std::optional<Vector3f>& up) {
  std::vector<Facet> facets;
  for (std::size_t i = 0; i < keyframes.size(); i += step_for(keyframes.size(), kMostForLevel))
    if (const auto record = decode_keyframe(keyframes[i].body))
      add_facets(record->grid, keyframes[i].T_map_keyframe, facets);
  return level_frame(facets, up ? *up : up_of_keyframes(keyframes, kMostForLevel));
}

}  // namespace

Result<Survey> survey(std::span<const PlacedKeyframe> keyframes, const SurveyConfig& config,
                      const std::optional<Vector3f>& up, const std::function<bool()>& stop) {
  const auto T_level_map = find_level(keyframes, up);
  if (!T_level_map) return Error{"floor plan", "no floor is seen"};
  FreeSpace space(config.space);
  Survey out;
  const std::size_t step = step_for(keyframes.size(), config.most_keyframes);
  for (std::size_t i = 0; i < keyframes.size(); i += step) {
    if (stop()) return Error{"floor plan", "left off"};
    const auto record = decode_keyframe(keyframes[i].body);
    if (record)
      space.carve(record->grid, *T_level_map * keyframes[i].T_map_keyframe);
    else
      ++out.keyframes_malformed;
  }
  auto plan = floor_plan(space, config.plan);
  if (!plan) return plan.error();
  out.plan = std::move(*plan);
  out.T_level_map = *T_level_map;
  out.space = space.counters();
  out.blocks = space.used();
  out.keyframes_left_out = keyframes.size() - (keyframes.size() + step - 1) / step;
  return out;
}

}  // namespace onemap::mapping
