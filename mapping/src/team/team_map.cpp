#include "mapping/team/team_map.hpp"

#include <algorithm>

#include "mapping/records/keyframe.hpp"
#include "mapping/team/link_table.hpp"
#include "mapping/team/placed_anchors.hpp"
#include "mapping/team/way_on_map.hpp"

namespace onemap::mapping {

TeamMap::TeamMap(const RobotId& self, std::uint64_t incarnation, const TeamMapConfig& config)
    : self_(self),
      config_(config),
      log_(self, incarnation, config.read_again != nullptr),
      presence_(self, config.lost_after),
      places_(config.places),
      loops_(config.verify, config.merge_while_mapping),
      verifier_(config.verify, places_, config.merge_while_mapping, config.lost_after),
      solver_(map_parameters(config.atlas)),
      decision_(config.lost_after),
      fusion_(config.atlas.map.budget_bytes, config.read_again),
      needless_(config.read_again) {}

void TeamMap::apply(const RecordPtr& record, Instant now) {
  const TeamMember* before = log_.find(ChainId{record->id.log.robot, record->id.log.incarnation});
  const bool greeted = before != nullptr && before->counts();
  view_.settled = false;  // until somebody has looked
  const auto taken = log_.apply(record, now);
  if (!taken)
    refuse(record->id, record->kind, taken.error().text());
  else if (*taken)
    tell(*record, !greeted);
  const std::vector<RecordId> unread = log_.let_go_keyframes({record->id.log.robot, record->id.log.incarnation});
  spare_.unread.insert(spare_.unread.end(), unread.begin(), unread.end());
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
  const ChainId chain{robot, record.id.log.incarnation};
  const TeamMember* member = log_.find(chain);
  if (member == nullptr) return;
  const auto kind = static_cast<RecordKind>(record.kind);
  if (kind == RecordKind::hello && first_hello && robot != self_)
    events_.emplace_back(RobotJoined{robot, member->camera});
  if (kind == RecordKind::finished && member->finished) events_.emplace_back(RobotFinished{robot, *member->finished});
  if (kind == RecordKind::ruling)
    if (const auto ruling = decode_ruling(record.body); ruling) events_.emplace_back(PairRuled{robot, *ruling});
  if (kind != RecordKind::link) return;
  if (const auto link = decode_link(record.body); link) events_.emplace_back(LinkLooked{chain, *link});
}

void TeamMap::begin_life(std::uint64_t incarnation, bool repeats) {
  log_.begin_life(incarnation, repeats);
  view_.chain += repeats ? 0 : 1;
  view_.T_map_odometry.reset();
  view_.settled = false;
  say_again_ = published_.has_value();
  voxels_thinned_.records = keyframes_thinned_.records = 0;
  frontier_ = {};
  unwritten_.clear();
}

void TeamMap::presence(std::map<RobotId, Instant> last_sign, std::set<RobotId> records_complete) {
  presence_.update(std::move(last_sign), std::move(records_complete));
}

bool TeamMap::step(Instant now, const Stop& stop) {
  worked_ = Work::none;
  now_ = now;
  const Agreement team(log_, presence_, now);
  note_end(team, now);
  note_links();
  return find_loops(team, now, stop) || verify(team, now, stop) || decide(team, now) || fuse(team, now, stop) ||
         look_for_needless(now);
}

// While robots map, solving gets a tenth of the time at most, fusing a third, and each look for what is needless a
// twentieth.
void TeamMap::took(Duration cost) {
  if (worked_ == Work::verified) verifier_.took(cost);
  if (worked_ == Work::solved) next_solve_ += 10 * cost;
  if (worked_ == Work::fused) next_aim_ += 3 * cost;
  if (worked_ == Work::thinned_voxels) voxels_thinned_.next += 20 * cost;
  if (worked_ == Work::thinned_keyframes) keyframes_thinned_.next += 20 * cost;
}

bool TeamMap::find_loops(const Agreement& team, Instant now, const Stop& stop) {
  const bool looked = loops_.look(team, places_, stop);
  if (const auto loops = loops_.news(team, now)) records_.push_back({Lane::poses, RecordKind::link, encode(*loops)});
  return looked;
}

bool TeamMap::verify(const Agreement& team, Instant now, const Stop& stop) {
  const auto look = verifier_.next(team, now, stop);
  if (!look) return false;
  worked_ = Work::verified;
  const ChainId other{look->link.a == self_ ? look->link.b : look->link.a, look->link.incarnation_other};
  if (look->news) {
    records_.push_back({Lane::poses, RecordKind::link, encode(look->link)});
    unwritten_.erase(other);
    return true;
  }
  const auto before = unwritten_.find(other);
  const bool again = before != unwritten_.end() && before->second.reason == look->link.reason;
  unwritten_.insert_or_assign(other, look->link);
  events_.emplace_back(LinkLooked{log_.own_chain(), look->link, again});
  return true;
}

bool TeamMap::map_is_due(const Agreement& team) const {
  if (team.ready()) return true;
  if (config_.merge_while_mapping <= Duration::zero() || team.over()) return false;
  return team.robots().size() == 1 || linked_once_;
}

bool TeamMap::publish(SolutionRecord solution) {
  records_.push_back({Lane::poses, RecordKind::solution, encode(solution)});
  published_ = std::move(solution);
  say_again_ = false;
  next_frontier_ = {};
  return true;
}

bool TeamMap::decide(const Agreement& team, Instant now) {
  if (!map_is_due(team) || decision_.decider(team) != self_) return false;
  if (!team.ready()) return decide_now(team, now) || say_frontier(now);
  // The links are all that will come: the very solution that follows from them.
  auto wanted = solver_.wanted(team, nullptr);
  if (wanted) wanted->up = up_.final(log_, *wanted);
  if (!wanted || (wanted == published_ && !say_again_)) return false;
  const TeamMember* made = decision_.made(team, solver_);
  if (made != nullptr && made->solution != published_) return false;  // of one that has gone
  return publish(std::move(*wanted));
}

// While robots map: whatever is near enough to the solution in use, which may be of one that has gone.
bool TeamMap::decide_now(const Agreement& team, Instant now) {
  if (log_.revision() == solved_revision_ || now < next_solve_) return false;
  solved_revision_ = log_.revision();
  next_solve_ = now + config_.map_interval;
  worked_ = Work::solved;
  const TeamMember* made = published_ ? nullptr : decision_.made(team, solver_);
  const SolutionRecord* in_use = published_ ? &*published_ : made != nullptr ? &*made->solution : nullptr;
  auto wanted = solver_.wanted(team, in_use);
  if (!wanted) return false;
  if (published_ && published_->map == wanted->map && agree(log_, *published_, *wanted, TeamSolver::kWorth_m))
    return say_again_ && publish(SolutionRecord(*published_));
  wanted->up = up_.now(log_, *wanted, in_use);
  return publish(std::move(*wanted));
}

bool TeamMap::say_frontier(Instant now) {
  if (!published_ || now < next_frontier_) return false;
  FrontierRecord here{digest(*published_), everything_here(log_, *published_)};
  if (here == frontier_) return false;
  frontier_ = std::move(here);
  next_frontier_ = now + config_.map_interval;
  records_.push_back({Lane::poses, RecordKind::frontier, encode(frontier_)});
  return true;
}

std::optional<MapTarget> TeamMap::target(const Agreement& team) {
  const TeamMember* made = map_is_due(team) ? decision_.made(team, solver_) : nullptr;
  if (made == nullptr) return std::nullopt;
  if (team.ready()) return MapTarget{*made->solution, everything_here(log_, *made->solution)};
  const auto here = [&](const FrontierRecord& said) { return holds(log_, said.chains); };
  const FrontierRecord* frontier = made->frontiers.newest(made->solution_digest, here);
  if (frontier == nullptr) return std::nullopt;
  return MapTarget{*made->solution, frontier->chains};
}

bool TeamMap::all_here(const Agreement& team, const SolutionRecord& solution) const {
  return std::ranges::all_of(solution.robots, [&](const SolvedRobot& solved) { return team.all_here(solved.chain); });
}

// What was begun while robots map is finished first, even when it is out of date by then.
void TeamMap::take_aim(const Agreement& team, Instant now) {
  const bool waits = !team.ready() || fusion_.submaps_unread() > 0;
  if (waits && (fusion_.underway() || now < next_aim_)) return;
  auto wanted = target(team);
  if (!wanted) return;
  final_ = team.ready() && all_here(team, wanted->solution);
  if (fusion_.aims_at(*wanted) || (!final_ && now < next_aim_)) return;
  next_aim_ = now + config_.map_interval / 4;  // frontiers come once in an interval: one that has come does not wait
  fusion_.aim(log_, std::move(*wanted));
  if (fusion_.done()) fused();
}

bool TeamMap::fuse(const Agreement& team, Instant now, const Stop& stop) {
  const std::uint64_t before = view_.digest;
  take_aim(team, now);
  if (!fusion_.underway()) return view_.digest != before;
  if (!fusion_.step(stop)) return false;
  worked_ = Work::fused;
  if (fusion_.done()) fused();
  return true;
}

// Whether it is time for one, which counts from now on.
bool TeamMap::Thinning::begin(Instant now, std::size_t there, std::size_t many) {
  constexpr Duration kLook = std::chrono::seconds(10);
  if (now < next && there < records + many) return false;
  next = now + kLook;
  records = there;
  return true;
}

// Own records that later ones have made needless, now and then, and after so many more: recordings are played as fast
// as it goes. Voxels, which are most of what a robot holds, do not wait for keyframes, which take longer.
bool TeamMap::look_for_needless(Instant now) {
  constexpr std::size_t kManyVoxels = 40, kManyKeyframes = 100;
  const TeamMember* own = log_.own();
  if (own == nullptr || own->finished || !fusion_.done()) return false;
  const SolvedRobot* solved = find_solved(*fusion_.solution(), log_.own_chain());
  if (solved == nullptr) return false;
  if (voxels_thinned_.begin(now, own->submaps.size(), kManyVoxels)) {
    worked_ = Work::thinned_voxels;
    thin_voxels(*own, *solved);
    return true;
  }
  if (!keyframes_thinned_.begin(now, own->keyframes.size(), kManyKeyframes)) return false;
  worked_ = Work::thinned_keyframes;
  thin_keyframes(*own, *solved);
  return true;
}

void TeamMap::thin_voxels(const TeamMember& own, const SolvedRobot& solved) {
  const LogId log{self_, static_cast<std::uint8_t>(Lane::voxels), own.incarnation};
  for (const std::uint32_t sequence : needless_.look(own, solved)) {
    spare_.needless.push_back({log, sequence});
    ++view_.needless;
  }
}

void TeamMap::thin_keyframes(const TeamMember& own, const SolvedRobot& solved) {
  for (const std::size_t position : needless_keyframes_.look(self_, own, solved, places_)) {
    const Record& record = *own.keyframes[position];
    const auto keyframe = decode_keyframe(record.body);
    if (!keyframe) continue;
    spare_.keyframes.push_back({record.id, encode(place_alone(*keyframe))});
    ++view_.needless_keyframes;
  }
}

void TeamMap::finish_fusion(const Stop& stop) {
  while (fusion_.underway() && fusion_.step(stop))
    if (fusion_.done()) fused();
}

void TeamMap::fused() {
  constexpr std::size_t kDigests = 32;
  for (const auto& [id, reason] : fusion_.take_malformed())
    if (malformed_.insert(id).second) refuse(id, static_cast<std::uint16_t>(RecordKind::submap), reason);
  fused_anew_ = true;
  view_.digest = fusion_.digest();
  if (view_.digests.size() == kDigests) view_.digests.erase(view_.digests.begin());
  if (view_.digest != 0) view_.digests.push_back(view_.digest);
  std::set<RobotId> robots;
  for (const SolvedRobot& solved : fusion_.solution()->robots) robots.insert(solved.chain.robot);
  view_.robots_in_map = robots.size();
  for (const ChainExtent& extent : fusion_.target()->extents) {
    if (fusion_.submaps_unread() > 0) break;  // what replaced records said is still in the map, to be taken back
    const std::vector<RecordId> unread = log_.let_go(extent.chain, extent.submaps);
    spare_.unread.insert(spare_.unread.end(), unread.begin(), unread.end());
  }
  view_.keyframes_in_map.clear();
  for (const ChainExtent& extent : fusion_.target()->extents)
    if (log_.present(extent.chain.robot) == extent.chain) view_.keyframes_in_map[extent.chain.robot] = extent.keyframes;
  view_.blocks = fusion_.map()->used();
  view_.blocks_refused = fusion_.map()->counters().blocks_refused;
  view_.submaps_left_out = fusion_.submaps_left_out();
  view_.submaps_unread = fusion_.submaps_unread();
  view_.blocks_unplaced = fusion_.blocks_unplaced();
  view_.T_map_odometry.reset();
  if (const SolvedRobot* solved = find_solved(*fusion_.solution(), log_.own_chain()); solved != nullptr && log_.own())
    view_.T_map_odometry = correction_now(*log_.own(), *solved);
  tell_fused(final_);
}

// A map that grows is told now and then.
void TeamMap::tell_fused(bool final) {
  constexpr Duration kTellAgain = std::chrono::seconds(10);
  const std::uint64_t solution = mapping::digest(*fusion_.solution());
  if (view_.digest == 0) return;  // what could not be read is said
  if (!final && (view_.blocks == 0 || (told_ && told_->first == solution && now_ - told_->second < kTellAgain))) return;
  told_ = {solution, now_};
  events_.emplace_back(MapFused{final, view_.digest, *fusion_.solution(), fusion_.submaps(), fusion_.submaps_left_out(),
                                fusion_.map()->used(), view_.blocks_refused});
}

void TeamMap::note_end(const Agreement& team, Instant now) {
  const bool over = !team.robots().empty() && team.over();
  if (over && !over_) over_at_ = now;
  over_ = over;
}

// What was one map goes on, also while its only link is taken back and comes again.
void TeamMap::note_links() {
  const auto accepted = [](const TeamLink& l) { return l.link->reason == LinkReason::accepted; };
  linked_once_ = linked_once_ || std::ranges::any_of(counting_links(log_), accepted);
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
  view_.greeted = {team.robots().begin(), team.robots().end()};
  view_.places_left_out = places_.left_out();
  const TeamMember* own = log_.own();
  const bool can_be_thinned = own != nullptr && !own->finished && view_.T_map_odometry;
  view_.unthinned = can_be_thinned ? own->submaps.size() - voxels_thinned_.records : 0;
  view_.robots_finished = 0;
  for (const RobotId& robot : team.robots()) view_.robots_finished += log_.find(robot)->finished ? 1 : 0;
  view_.waiting = team.waiting();
  const auto elected = decision_.decider(team);
  const TeamMember* final = team.ready() ? decision_.made(team, solver_) : nullptr;
  if (view_.waiting.empty() && team.ready() && elected && *elected != self_ && final == nullptr)
    view_.waiting.push_back({*elected, Waiting::What::solution, team.silent(*elected)});
  const bool everything = std::ranges::all_of(team.chains(), [&](const ChainId& c) { return team.all_here(c); });
  const bool settled =
      final != nullptr && everything && fusion_.at({*final->solution, everything_here(log_, *final->solution)});
  if (settled && std::exchange(told_settled_, view_.digest) != view_.digest)
    events_.emplace_back(MapSettled{view_.digest, view_.blocks, view_.submaps_refused});
  view_.settled = settled;
  view_.merge = settled ? std::max(Duration::zero(), Duration(fused_at_ - over_at_)) : Duration::zero();
}

void TeamMap::observe(Instant now) {
  if (std::exchange(fused_anew_, false)) fused_at_ = now;
  const Agreement team(log_, presence_, now);
  note_gone(team);
  if (const auto passed_over = decision_.look(team, map_is_due(team), solver_, now)) events_.emplace_back(*passed_over);
  update_view(team);
}

}  // namespace onemap::mapping
