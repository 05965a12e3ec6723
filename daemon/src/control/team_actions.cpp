#include "daemon/control/team_actions.hpp"

#include "daemon/control/replies.hpp"
#include "daemon/link_tally.hpp"
#include "daemon/team_words.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using control::Json;

namespace {
Json chain_json(const mapping::ChainId& chain) { return {{"robot", chain.robot.name()}, {"life", chain.incarnation}}; }

Json link_json(const std::optional<mapping::LinkRecord>& link) {
  if (!link) return nullptr;
  return {{"accepted", link->reason == mapping::LinkReason::accepted},
          {"reason", LinkTally::reason(std::min(static_cast<std::size_t>(link->reason), LinkTally::kReasons - 1))},
          {"measured", link->measured},
          {"words", link_words(*link)},
          {"supporting_pairs", link->supporting_pairs},
          {"inliers", link->inliers},
          {"error_mm", link->error_um * 1e-3}};
}

Json ruling_json(const std::optional<mapping::Rulings::Ruling>& ruling) {
  if (!ruling) return nullptr;
  return {{"apart", ruling->apart}, {"by", ruling->by.robot.name()}, {"turn", ruling->turn}};
}

Json pair_json(const mapping::WhyPair& pair) {
  Json uses = Json::object();
  for (const auto& [use, count] : pair.pairs) uses[std::string(mapping::to_string(use))] = count;
  return {{"a", chain_json(pair.a)},
          {"b", chain_json(pair.b)},
          {"link", link_json(pair.link)},
          {"ruling", ruling_json(pair.ruling)},
          {"verdict", mapping::to_string(pair.verdict.reason)},
          {"number", pair.verdict.number},
          {"links", pair.verdict.links},
          {"agree", pair.verdict.agree},
          {"used", pair.verdict.used},
          {"uses", std::move(uses)},
          {"worst_sigmas", pair.worst}};
}

Result<RobotId> robot_in(const Json& request, const char* key) {
  const auto name = text_in(request, key, "");
  if (!name) return name.error();
  if (!RobotId::valid_name(*name)) return Error{"", std::string(key) + ": expected the name of a robot"};
  return RobotId::from_name(*name);
}

// Asks the team about the two robots of a request.
template <class Question>
ControlActions::Action about_two(Team& team, Question question) {
  return [&team, question](const Json& request, const Later& later) {
    const auto a = robot_in(request, "a"), b = robot_in(request, "b");
    if (!a || !b) return later(!a ? a.error() : b.error());
    team.ask([=, a = *a, b = *b](mapping::TeamMap& map) {
      later(question(map, a, b));
      return true;
    });
  };
}

Result<Json> counted(const Result<std::size_t>& pairs) {
  if (!pairs) return pairs.error();
  return Json{{"pairs", *pairs}};
}
}  // namespace

Json why_json(const mapping::Why& why) {
  Json way = Json::array(), pairs = Json::array();
  for (const mapping::ChainId& chain : why.way) way.push_back(chain_json(chain));
  for (const mapping::WhyPair& pair : why.pairs) pairs.push_back(pair_json(pair));
  return {{"one_map", why.one_map}, {"way", std::move(way)}, {"pairs", std::move(pairs)}};
}

ControlActions team_actions(Team& team) {
  ControlActions actions;
  actions.why = about_two(team, [](mapping::TeamMap& map, const RobotId& a, const RobotId& b) -> Result<Json> {
    const auto why = map.why(a, b);
    if (!why) return why.error();
    return why_json(*why);
  });
  actions.unmerge = about_two(
      team, [](mapping::TeamMap& map, const RobotId& a, const RobotId& b) { return counted(map.unmerge(a, b)); });
  actions.merge = about_two(
      team, [](mapping::TeamMap& map, const RobotId& a, const RobotId& b) { return counted(map.merge(a, b)); });
  return actions;
}

}  // namespace onemap::daemon
