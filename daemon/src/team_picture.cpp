#include "daemon/team_picture.hpp"

#include <algorithm>

#include "daemon/team_words.hpp"

namespace onemap::daemon {

namespace {

bool in_map(const std::optional<mapping::SolutionRecord>& solution, const RobotId& robot) {
  return solution && std::ranges::any_of(solution->robots, [&](const auto& solved) { return solved.robot == robot; });
}

}  // namespace

render::TeamPicture team_picture(const mapping::TeamMap& team) {
  render::TeamPicture picture;
  std::vector<RobotId> ids;
  std::vector<std::string> names;
  for (const auto& [id, member] : team.members()) {
    ids.push_back(id);
    names.push_back(id.name());
  }
  const auto colors = render::robot_colors(names);
  const auto solution = team.solution();
  for (std::size_t i = 0; i < ids.size(); ++i)
    picture.robots.push_back({names[i], colors[i], team.members().at(ids[i]).places.size(), in_map(solution, ids[i])});
  const auto number = [&](const RobotId& id) {
    return static_cast<std::size_t>(std::ranges::find(ids, id) - ids.begin());
  };
  for (const mapping::LinkRecord& link : team.links())
    picture.links.push_back({number(link.a), number(link.b), link.reason == mapping::LinkReason::accepted, link.inliers,
                             link_words(link.reason)});
  if (solution) picture.reference = solution->reference.name();
  return picture;
}

}  // namespace onemap::daemon
