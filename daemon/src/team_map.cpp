#include "daemon/team_map.hpp"

#include <algorithm>

#include "mapping/team/reference.hpp"

namespace onemap::daemon {

using mapping::RecordKind;

namespace {

std::vector<mapping::KeyframeRecord> decode_keyframes(const TeamMember& member) {
  std::vector<mapping::KeyframeRecord> keyframes;
  keyframes.reserve(member.keyframes.size());
  for (const auto& record : member.keyframes)
    if (auto keyframe = mapping::decode_keyframe(record->body)) keyframes.push_back(std::move(*keyframe));
  return keyframes;
}

bool equal(const std::optional<mapping::SolutionRecord>& a, const std::optional<mapping::SolutionRecord>& b) {
  return a.has_value() == b.has_value() && (!a || encode(*a) == encode(*b));
}

const char* words(mapping::LinkReason reason) {
  switch (reason) {
    case mapping::LinkReason::accepted:
      return "accepted";
    case mapping::LinkReason::too_few_matches:
      return "too few matches";
    case mapping::LinkReason::fundamental_failed:
      return "no fundamental matrix";
    case mapping::LinkReason::depth_incoherent:
      return "depth does not agree";
    case mapping::LinkReason::ransac_failed:
      return "no rigid motion agrees";
    case mapping::LinkReason::icp_failed:
      return "the clouds do not fit";
    case mapping::LinkReason::inconsistent:
      return "pairs of clouds contradict each other";
  }
  return "a reason of a later version";
}

template <class Record>
Status keep(Result<Record> decoded, std::optional<Record>& place) {
  if (!decoded) return decoded.error();
  place = std::move(*decoded);
  return success();
}

}  // namespace

TeamMap::TeamMap(const RobotId& self, const TeamMapConfig& config, Publish publish, Log& log)
    : self_(self), config_(config), publish_(std::move(publish)), log_(log) {}

void TeamMap::apply(const std::shared_ptr<const comms::Record>& record, Instant now) {
  const RobotId author = record->id.log.robot;
  TeamMember* member = member_of(record->id.log);
  if (!member) return;
  const Status status = decode_into(*member, record);
  if (!status) {
    ++refused_;
    log_.limited("record", "record {} of {} refused: {}", record->id.seq, author.name(), status.error().text());
  }
  if (!all_finished())
    all_finished_seen_ = false;
  else if (!all_finished_seen_) {
    all_finished_seen_ = true;
    all_finished_at_ = now;
  }
  settled_ = false;
}

TeamMember* TeamMap::member_of(const comms::LogId& log) {
  TeamMember& member = members_[log.robot];
  if (log.incarnation < member.incarnation) return nullptr;
  if (log.incarnation > member.incarnation) {
    // The robot started anew: what was concluded from its earlier life goes with that life.
    std::erase_if(links_,
                  [&](const auto& link) { return link.first.first == log.robot || link.first.second == log.robot; });
    std::erase_if(verified_, [&](const Pair& pair) { return pair.first == log.robot || pair.second == log.robot; });
    member = TeamMember{};
    member.incarnation = log.incarnation;
  }
  return &member;
}

Status TeamMap::decode_into(TeamMember& member, const std::shared_ptr<const comms::Record>& record) {
  switch (static_cast<RecordKind>(record->kind)) {
    case RecordKind::hello: {
      auto hello = mapping::decode_hello(record->body);
      if (!hello) return hello.error();
      member.name = hello->name;
      member.camera = hello->camera;
      if (record->id.log.robot != self_) log_.line("robot {} joined with {}", member.name, member.camera);
      return success();
    }
    case RecordKind::keyframe: {
      auto keyframe = mapping::decode_keyframe(record->body);
      member.keyframes.push_back(record);  // counted even when odd: completeness is by number
      if (!keyframe) return keyframe.error();
      member.keyframe_poses.push_back(keyframe->T_robot_keyframe);
      return success();
    }
    case RecordKind::trajectory: {
      auto batch = mapping::decode_trajectory(record->body);
      if (!batch) return batch.error();
      member.poses.insert(member.poses.end(), batch->poses.begin(), batch->poses.end());
      return success();
    }
    case RecordKind::submap:
      member.submaps.push_back(record);
      return success();
    case RecordKind::link:
      return add_link(record->id.log.robot, record->body);
    case RecordKind::solution:
      return keep(mapping::decode_solution(record->body), member.solution);
    case RecordKind::finished: {
      Status status = keep(mapping::decode_finished(record->body), member.finished);
      if (status)
        log_.line("robot {} finished: {} frames, {} tracked, {} keyframes, {} submaps", record->id.log.robot.name(),
                  member.finished->frames, member.finished->tracked, member.finished->keyframes,
                  member.finished->submaps);
      return status;
    }
  }
  return Error{"kind " + std::to_string(record->kind), "not known to this version"};
}

Status TeamMap::add_link(const RobotId& author, std::span<const std::uint8_t> body) {
  auto link = mapping::decode_link(body);
  if (!link) return link.error();
  if (link->a != author || !(link->a < link->b)) return Error{"link", "not written by the lower robot of its pair"};
  const Pair pair{link->a, link->b};
  if (link->reason == mapping::LinkReason::accepted)
    log_.line("link {} - {} accepted: {} pairs of clouds agree, {} inliers, ratio {:.2f}, error {:.1f} mm",
              link->a.name(), link->b.name(), link->supporting_pairs, link->inliers, link->ratio_e4 * 1e-4,
              link->error_um * 1e-3);
  else
    log_.line("link {} - {} refused: {}, {} pairs of clouds agree, {} inliers", link->a.name(), link->b.name(),
              words(link->reason), link->supporting_pairs, link->inliers);
  links_.insert_or_assign(pair, *link);
  return success();
}

bool TeamMap::step() { return verify_next_pair() || decide() || fuse(); }

bool TeamMap::verify_next_pair() {
  const auto self = members_.find(self_);
  if (self == members_.end() || !self->second.keyframes_complete()) return false;
  for (const auto& [other, member] : members_) {
    const Pair pair{self_, other};
    if (!(self_ < other) || !member.keyframes_complete() || verified_.contains(pair)) continue;
    verified_.insert(pair);
    const auto mine = decode_keyframes(self->second), theirs = decode_keyframes(member);
    const auto link = mapping::verify_robots(self_, mine, other, theirs, config_.verify);
    publish_({mapping::Lane::poses, RecordKind::link, encode(link)});
    return true;
  }
  return false;
}

std::vector<RobotId> TeamMap::robots() const {
  std::vector<RobotId> ids;
  for (const auto& [id, member] : members_)
    if (!member.name.empty()) ids.push_back(id);
  return ids;
}

bool TeamMap::all_finished() const {
  return !members_.empty() &&
         std::ranges::all_of(members_, [](const auto& m) { return m.second.finished.has_value(); });
}

bool TeamMap::all_linked() const {
  const auto ids = robots();
  for (std::size_t i = 0; i < ids.size(); ++i)
    for (std::size_t j = i + 1; j < ids.size(); ++j)
      if (!links_.contains({ids[i], ids[j]})) return false;
  return true;
}

std::optional<mapping::SolutionRecord> TeamMap::wanted_solution() const {
  if (!all_finished() || !all_linked()) return std::nullopt;
  std::vector<mapping::LinkRecord> links;
  for (const auto& [pair, link] : links_) links.push_back(link);
  return mapping::solve(robots(), links);
}

bool TeamMap::decide() {
  const auto ids = robots();
  if (ids.empty() || mapping::elect(ids) != self_) return false;
  auto wanted = wanted_solution();
  if (!wanted || equal(wanted, published_)) return false;
  published_ = std::move(wanted);
  publish_({mapping::Lane::poses, RecordKind::solution, encode(*published_)});
  return true;
}

const mapping::SolutionRecord* TeamMap::current_solution() const {
  for (const auto& [id, member] : members_)
    if (member.solution) return &*member.solution;
  return nullptr;
}

std::size_t TeamMap::submaps_in(const mapping::SolutionRecord& solution) const {
  std::size_t count = 0;
  for (const auto& robot : solution.robots)
    if (const auto member = members_.find(robot.robot); member != members_.end())
      count += member->second.submaps.size();
  return count;
}

bool TeamMap::fuse() {
  const mapping::SolutionRecord* solution = current_solution();
  if (!solution) return false;
  for (const auto& robot : solution->robots) {
    const auto member = members_.find(robot.robot);
    if (member == members_.end() || !member->second.complete()) return false;  // its voxels are still on their way
  }
  if (equal(fused_, *solution) && fused_submaps_ == submaps_in(*solution)) return false;
  std::vector<mapping::SubmapRecord> decoded;
  std::vector<mapping::Atlas::Submap> submaps;
  decoded.reserve(submaps_in(*solution));  // pointers into it stay valid
  for (const auto& robot : solution->robots)
    for (const auto& record : members_.at(robot.robot).submaps) {
      auto submap = mapping::decode_submap(record->body);
      if (!submap) {
        ++refused_;
        log_.limited("record", "submap {} of {} refused: {}", record->id.seq, robot.robot.name(),
                     submap.error().text());
        continue;
      }
      decoded.push_back(std::move(*submap));
      submaps.push_back({robot.robot, record->id.seq, &decoded.back()});
    }
  if (!atlas_) atlas_ = std::make_unique<mapping::Atlas>(config_.atlas);
  atlas_->rebuild(*solution, submaps);
  fused_ = *solution;
  fused_submaps_ = submaps_in(*solution);
  fused_anew_ = true;
  digest_ = atlas_->digest();
  log_fused();
  return true;
}

void TeamMap::log_fused() const {
  std::string names;
  for (const auto& robot : fused_->robots) names.append(" ").append(robot.robot.name());
  log_.line("global map {:016x}: reference {}, {} links, robots{}, {} blocks, {} refused", digest_,
            fused_->reference.name(), fused_->links_used, names, atlas_->map().used(),
            atlas_->map().counters().blocks_refused);
}

void TeamMap::observe(Instant now) {
  if (fused_anew_) fused_at_ = now;
  fused_anew_ = false;
  if (settled_ || !fused_) return;
  for (const auto& [id, member] : members_)
    if (member.name.empty() || !member.complete()) return;
  const auto wanted = wanted_solution();
  if (!wanted || !equal(wanted, fused_) || fused_submaps_ != submaps_in(*fused_)) return;
  settled_ = true;
}

TeamView TeamMap::view() const {
  TeamView view;
  view.robots_known = robots().size();
  for (const auto& [id, member] : members_) view.robots_finished += member.finished ? 1 : 0;
  view.settled = settled_;
  if (settled_) view.merge = std::max(Duration::zero(), fused_at_ - all_finished_at_);
  if (fused_) {
    view.robots_in_map = fused_->robots.size();
    view.digest = digest_;
  }
  return view;
}

}  // namespace onemap::daemon
