#include "daemon/team_picture.hpp"

#include <algorithm>

#include "daemon/team_words.hpp"
#include "mapping/team/placed_anchors.hpp"

namespace onemap::daemon {

namespace {

bool in_map(const mapping::SolutionRecord* solution, const mapping::ChainId& chain) {
  return solution != nullptr && mapping::find_solved(*solution, chain) != nullptr;
}

}  // namespace

render::TeamPicture team_picture(const mapping::TeamMap& team, const std::vector<Merge>& merges) {
  render::TeamPicture picture;
  const std::vector<mapping::ChainId> chains = team.log().chains();
  std::vector<std::string> names;
  names.reserve(chains.size());
  for (const mapping::ChainId& chain : chains) names.push_back(chain_name(team.log(), chain));
  const auto colors = render::robot_colors(names);
  const mapping::SolutionRecord* solution = team.solution();
  for (std::size_t i = 0; i < chains.size(); ++i)
    picture.robots.push_back(
        {names[i], colors[i], team.log().find(chains[i])->keyframes.chain().size(), in_map(solution, chains[i])});
  const auto number = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  for (const Merge& merge : merges)
    picture.links.push_back(
        {number(merge.a), number(merge.b), merge.refused.empty(), merge.inliers, merge.pairs, merge.refused});
  if (solution != nullptr) picture.reference = chain_name(team.log(), solution->reference);
  return picture;
}

}  // namespace onemap::daemon
