#include "mapping/team/team_map.hpp"

#include <algorithm>

#include "mapping/team/link_table.hpp"

namespace onemap::mapping {

TeamMap::TeamMap(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config)
    : self_(self),
      config_(config),
      log_(self, incarnation),
      presence_(self, config.lost_after),
      places_(config.places),
      loops_(config.verify, config.merge_while_mapping),
      verifier_(config.verify, places_, config.merge_while_mapping, config.lost_after),
      decision_(config.lost_after),
      fusion_(config.atlas) {}

void TeamMap::apply(const RecordPtr& record, Instant now) {
  const TeamMember* before = log_.find(record->id.log.robot);
  const bool greeted = before != nullptr && before->counts() && before->incarnation == record->id.log.incarnation;
  view_.settled = false;  // until somebody has looked
  const auto taken = log_.apply(record, now);
  if (!taken)
    refuse(record->id, record->kind, taken.error().text());
  else if (*taken)
    tell(*record, !greeted);
}

void TeamMap::refuse(const RecordId& id, std::uint16_t kind, const std::string& reason) {
  RefusedRecords& refused = refused_[kind];
  ++refused.count;
  refused.last_reason = reason;
  ++view_.records_refused;
  if (static_cast<RecordKind>(kind) == RecordKind::submap) ++view_.submaps_refused;
  events_.emplace_back(RecordRefused{id, kind, reason});
}

void TeamMap::tell(const Record& record, bool first_hello) {
  const RobotId& robot = record.id.log.robot;
  const TeamMember* member = log_.find(robot);
  if (member == nullptr) return;
  const auto kind = static_cast<RecordKind>(record.kind);
  if (kind == RecordKind::hello && first_hello && robot != self_)
    events_.emplace_back(RobotJoined{robot, member->camera});
  if (kind == RecordKind::finished && member->finished) events_.emplace_back(RobotFinished{robot, *member->finished});
  if (kind != RecordKind::link) return;
  if (const auto link = decode_link(record.body); link) events_.emplace_back(LinkLooked{robot, *link});
}

void TeamMap::begin_life(std::uint64_t incarnation) {
  log_.begin_life(incarnation);
  view_.settled = false;
}

void TeamMap::presence(std::map<RobotId, Instant> last_sign, std::set<RobotId> records_complete) {
  presence_.update(std::move(last_sign), std::move(records_complete));
}

bool TeamMap::step(Instant now, const Stop& stop) {
  worked_ = Work::none;
  const Agreement team(log_, presence_, now);
  note_end(team, now);
  return find_loops(team, now, stop) || verify(team, now, stop) || decide(team) || fuse(team, now, stop);
}

void TeamMap::took(Duration cost) {
  if (worked_ == Work::verified) verifier_.took(cost);
  if (worked_ == Work::fused) next_interim_fusion_ += 10 * cost;
}

bool TeamMap::find_loops(const Agreement& team, Instant now, const Stop& stop) {
  const bool looked = loops_.look(team, places_, stop);
  if (const auto loops = loops_.news(team, now)) records_.push_back({Lane::poses, RecordKind::link, encode(*loops)});
  return looked;
}

bool TeamMap::verify(const Agreement& team, Instant now, const Stop& stop) {
  const auto look = verifier_.next(team, now, stop);
  if (!look) return false;
  if (look->news) records_.push_back({Lane::poses, RecordKind::link, encode(look->link)});
  worked_ = Work::verified;
  return true;
}

bool TeamMap::map_is_due(const Agreement& team) const {
  if (team.ready()) return true;
  if (config_.merge_while_mapping <= Duration::zero() || team.over()) return false;
  return std::ranges::any_of(counting_links(log_), [](const auto& l) { return l.reason == LinkReason::accepted; });
}

// Once the links are all that will come, the very solution that follows from them; before, whatever is near enough.
bool TeamMap::decide(const Agreement& team) {
  if (!map_is_due(team) || decision_.decider(team) != self_) return false;
  const SolutionRecord* mine = published_ ? &*published_ : nullptr;
  const auto wanted = solver_.wanted(team, mine);
  if (!wanted || same_solution(&*wanted, mine)) return false;
  const SolutionRecord* made = decision_.made(team, solver_);
  const bool mine_counts = made != nullptr && same_solution(made, mine);
  if (made != nullptr && !mine_counts) return false;  // of one that has gone
  if (mine_counts && !team.ready() && agree(log_, *mine, *wanted, TeamSolver::kWorth_m)) return false;
  published_ = wanted;
  records_.push_back({Lane::poses, RecordKind::solution, encode(*wanted)});
  return true;
}

bool TeamMap::fuse(const Agreement& team, Instant now, const Stop& stop) {
  const bool final = team.over(), outdated = fusion_.outdated(log_);
  const SolutionRecord* made = map_is_due(team) ? decision_.made(team, solver_) : nullptr;
  const bool current = made != nullptr && !outdated && fusion_.solution() && same_solution(&*fusion_.solution(), made);
  // What was begun while robots map is finished first, even when its solution is out of date by then.
  if (!fusion_.underway() || (!current && (outdated || final))) {
    if (made == nullptr || (current && fusion_.complete(log_))) return false;
    if (!final && now < next_interim_fusion_) return false;
    fusion_.begin(*made);
    next_interim_fusion_ = now + config_.merge_while_mapping;
  }
  const TeamMember* member = log_.find(fusion_.next());
  if (member == nullptr) return false;
  if (final && !team.all_here(fusion_.next())) return false;  // its voxels are still on their way
  if (!fusion_.add(*member, stop)) return false;
  worked_ = Work::fused;
  if (fusion_.done()) fused(final);
  return true;
}

void TeamMap::finish_fusion(const Stop& stop) {
  while (fusion_.underway()) {
    const TeamMember* member = log_.find(fusion_.next());
    if (member == nullptr || !fusion_.add(*member, stop)) break;
    if (fusion_.done()) fused(over_);
  }
}

void TeamMap::fused(bool final) {
  for (const auto& [id, reason] : fusion_.take_malformed())
    if (malformed_.insert(id).second) refuse(id, static_cast<std::uint16_t>(RecordKind::submap), reason);
  fused_anew_ = true;
  view_.digest = fusion_.digest();
  view_.robots_in_map = fusion_.solution()->robots.size();
  view_.blocks = fusion_.map()->used();
  view_.blocks_refused = fusion_.map()->counters().blocks_refused;
  view_.submaps_left_out = fusion_.submaps_left_out();
  view_.blocks_unplaced = fusion_.blocks_unplaced();
  events_.emplace_back(MapFused{final, view_.digest, *fusion_.solution(), fusion_.submaps(), fusion_.submaps_left_out(),
                                fusion_.map()->used(), view_.blocks_refused});
}

void TeamMap::note_end(const Agreement& team, Instant now) {
  const bool over = !team.robots().empty() && team.over();
  if (over && !over_) over_at_ = now;
  over_ = over;
}

void TeamMap::note_gone(const Agreement& team) {
  for (const RobotId& robot : team.gone())
    if (!view_.gone.contains(robot)) events_.emplace_back(RobotGone{robot, team.silent(robot)});
  for (const RobotId& robot : view_.gone)
    if (!team.gone().contains(robot)) events_.emplace_back(RobotBack{robot});
  view_.gone = team.gone();
  view_.cut_short.clear();
  for (const RobotId& robot : team.gone())
    if (const TeamMember* member = log_.find(robot); member != nullptr && !member->complete())
      view_.cut_short.insert(robot);
}

void TeamMap::update_view(const Agreement& team) {
  view_.robots_known = team.robots().size();
  view_.places_refused = places_.index().refused();
  view_.robots_finished = 0;
  for (const RobotId& robot : team.robots()) view_.robots_finished += log_.find(robot)->finished ? 1 : 0;
  view_.waiting = team.waiting();
  const auto elected = decision_.decider(team);
  const SolutionRecord* final = team.ready() ? decision_.made(team, solver_) : nullptr;
  if (view_.waiting.empty() && team.ready() && elected && *elected != self_ && final == nullptr)
    view_.waiting.push_back({*elected, Waiting::What::solution, team.silent(*elected)});
  const bool all_here = std::ranges::all_of(team.robots(), [&](const RobotId& r) { return team.all_here(r); });
  const bool settled =
      final != nullptr && all_here && fusion_.complete(log_) && same_solution(final, &*fusion_.solution());
  if (settled && std::exchange(told_settled_, view_.digest) != view_.digest)
    events_.emplace_back(MapSettled{view_.digest, view_.blocks, view_.submaps_refused});
  view_.settled = settled;
  view_.merge = settled ? std::max(Duration::zero(), Duration(fused_at_ - over_at_)) : Duration::zero();
}

void TeamMap::observe(Instant now) {
  if (std::exchange(fused_anew_, false)) fused_at_ = now;
  const Agreement team(log_, presence_, now);
  note_gone(team);
  if (const auto passed_over = decision_.look(team, team.ready(), solver_, now)) events_.emplace_back(*passed_over);
  update_view(team);
}

std::optional<SolutionRecord> TeamMap::solution() const { return fusion_.done() ? fusion_.solution() : std::nullopt; }

std::string TeamMap::graph() const {
  const auto solved = solution();
  return solved ? graph_text(log_, *solved) : std::string();
}

std::vector<LinkRecord> TeamMap::links() const { return counting_links(log_); }

}  // namespace onemap::mapping
