#include "daemon/map_drawing.hpp"

#include <algorithm>

#include "daemon/team_words.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/way_on_map.hpp"
#include "render/map_server_writer.hpp"

namespace onemap::daemon {

namespace {

constexpr std::size_t kMostOfALivePlan = 500;  // keyframes, which take milliseconds each

SavedPath make_path(const std::string& name, render::Color color, const std::vector<mapping::StampedPose>& poses,
                    const std::vector<mapping::QuantizedPose>& keyframes) {
  SavedPath path{name, color, {}, {}, keyframes};
  path.poses.reserve(poses.size());
  for (const mapping::StampedPose& pose : poses) path.poses.push_back(pose.T_robot_camera);
  return path;
}

// The same in every picture of the team, whoever draws it.
render::Color color_of(const mapping::TeamLog& log, const std::string& robot) {
  std::vector<std::string> names;
  const std::vector<RobotId> robots = log.robots();
  names.reserve(robots.size() + 1);
  for (const RobotId& id : robots) names.push_back(id.name());
  if (std::ranges::find(names, robot) == names.end()) names.push_back(robot);
  const auto place = std::ranges::find(names, robot) - names.begin();
  return render::robot_colors(names)[static_cast<std::size_t>(place)];
}

mapping::MapTarget own_target(const mapping::TeamLog& log, const mapping::AtlasConfig& config) {
  mapping::MapTarget target{mapping::alone_on_map(log.own_chain()), {}};
  target.solution.map = mapping::map_parameters(config);
  target.extents = mapping::everything_here(log, target.solution);
  return target;
}

}  // namespace

mapping::AtlasConfig global_map(const Config& config) {
  mapping::AtlasConfig out{config.mapper.map};
  out.map.budget_bytes = config.global_budget_bytes;
  return out;
}

Result<mapping::Survey> survey_of(const MapSource& from, const mapping::SurveyConfig& config,
                                  const std::function<bool()>& stop) {
  if (from.solution == nullptr)
    return survey(mapping::placed_keyframes(from.log, mapping::alone_on_map(from.log.own_chain())), config,
                  std::nullopt, stop);
  return survey(mapping::placed_keyframes(from.log, *from.solution), config, mapping::unit_vector(from.solution->up),
                stop);
}

Result<bool> write_plan(const MapSource& from, mapping::SurveyConfig config, const std::vector<std::string>& stems,
                        const std::function<bool()>& stop) {
  config.most_keyframes = std::min(config.most_keyframes, kMostOfALivePlan);
  const auto survey = survey_of(from, config, stop);
  if (!survey) return false;
  for (const std::string& stem : stems)
    if (auto written = render::write_map_server(stem, survey->plan, survey->T_level_map); !written)
      return written.error();
  return true;
}

std::vector<std::uint8_t> save_global(const MapSource& from, const std::string& title) {
  std::vector<SavedPath> paths;
  for (const mapping::SolvedRobot& solved : from.solution->robots)
    if (const mapping::TeamMember* member = from.log.find(solved.chain); member != nullptr) {
      std::vector<mapping::QuantizedPose> keyframes;
      for (const mapping::KeyframeOnMap& keyframe : mapping::keyframes_on_map(*member, solved))
        keyframes.push_back(keyframe.T_map_keyframe);
      paths.push_back(make_path(chain_name(from.log, solved.chain), color_of(from.log, solved.chain.robot.name()),
                                mapping::way_on_map(*member, solved), keyframes));
    }
  return save_map(title, paths, *from.map, from.solution->up);
}

std::optional<std::vector<std::uint8_t>> save_local(const MapSource& from, const Config& config,
                                                    const std::string& title, const std::function<bool()>& stop) {
  const mapping::TeamMember* own = from.log.own();
  if (own == nullptr) return std::nullopt;
  const mapping::AtlasConfig atlas = global_map(config);
  mapping::MapFusion local(atlas.map.budget_bytes);
  local.aim(from.log, own_target(from.log, atlas));
  while (local.underway())
    if (!local.step(stop) && stop()) return std::nullopt;
  std::vector<mapping::QuantizedPose> keyframes;
  const std::vector<mapping::KeyframePlace> chain = own->keyframes.chain();
  keyframes.reserve(chain.size());
  for (const mapping::KeyframePlace& place : chain) keyframes.push_back(place.T_robot_keyframe);
  const SavedPath path = make_path(config.id, color_of(from.log, config.id), own->trajectory.poses(), keyframes);
  return save_map(title, {&path, 1}, *local.map());
}

}  // namespace onemap::daemon
