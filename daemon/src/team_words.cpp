#include "daemon/team_words.hpp"

#include <fmt/format.h>

namespace onemap::daemon {

using mapping::LinkReason;

std::string link_words(const mapping::LinkRecord& link) {
  const double percent = link.measured * 1e-2;
  switch (link.reason) {
    case LinkReason::accepted:
      return "accepted";
    case LinkReason::too_few_matches:
      return fmt::format("too few features match ({})", link.measured);
    case LinkReason::fundamental_failed:
      return fmt::format("no fundamental matrix for {} matches", link.measured);
    case LinkReason::depth_incoherent:
      return fmt::format("of {} matches too few depths agree", link.measured);
    case LinkReason::ransac_failed:
      return fmt::format("no rigid motion fits more than {} matches", link.measured);
    case LinkReason::icp_failed:
      return fmt::format("the clouds do not fit (error {:.1f} mm)", link.measured * 1e-3);
    case LinkReason::inconsistent:
      return fmt::format("only {} pairs of clouds agree", link.measured);
    case LinkReason::little_overlap:
      return fmt::format("the clouds hardly overlap ({:.0f} %)", percent);
    case LinkReason::seen_through:
      return fmt::format("one lies where the other saw free space (but {:.0f} %)", percent);
    case LinkReason::another_place:
      return fmt::format("{} pairs of clouds agree on another place", link.measured);
    case LinkReason::not_seen_again:
      return fmt::format("of what both should have seen {:.0f} % look alike", percent);
  }
  return "a reason of a later version";
}

namespace {

struct Words {
  Log& log;

  void operator()(const mapping::RobotJoined& e) const {
    log.line("robot {} joined with {}", e.robot.name(), e.camera);
  }
  void operator()(const mapping::RobotFinished& e) const {
    log.line("robot {} finished: {} frames, {} tracked, {} keyframes, {} submaps", e.robot.name(), e.record.frames,
             e.record.tracked, e.record.keyframes, e.record.submaps);
  }
  void operator()(const mapping::RobotGone& e) const {
    log.warn("robot {} is not waited for any more: silent for {:.0f} s; its records stay, and it is welcome back",
             e.robot.name(), to_seconds(e.silent));
  }
  void operator()(const mapping::RobotBack& e) const { log.line("robot {} is back", e.robot.name()); }
  void operator()(const mapping::LinkLooked& e) const {
    const mapping::LinkRecord& link = e.link;
    if (e.again) return;
    if (link.a == link.b && link.incarnation_other == e.author.incarnation) {
      if (!link.pairs.empty())
        log.line("robot {} knows {} pairs of its keyframes as one place each", link.a.name(), link.pairs.size());
      return;
    }
    const std::string by = e.author.robot == link.a ? "" : fmt::format(" (looked at by {})", e.author.robot.name());
    const char* life = link.a == link.b ? "'s earlier life" : "";
    if (link.reason == LinkReason::accepted)
      log.line("link {}{} - {} accepted: {} pairs of clouds agree, {} inliers, ratio {:.2f}, error {:.1f} mm{}",
               link.a.name(), life, link.b.name(), link.supporting_pairs, link.inliers, link.ratio_e4 * 1e-4,
               link.error_um * 1e-3, by);
    else
      log.line("link {}{} - {} refused: {}, {} pairs of clouds agree, {} inliers{}", link.a.name(), life, link.b.name(),
               link_words(link), link.supporting_pairs, link.inliers, by);
  }
  void operator()(const mapping::PairRuled& e) const {
    const mapping::RulingRecord& r = e.ruling;
    const std::string pair = r.a == r.b ? fmt::format("own loops of {}", r.a.robot.name())
                                        : fmt::format("links {} - {}", r.a.robot.name(), r.b.robot.name());
    log.line("{} {}, a person says at {}", pair, r.apart ? "do not count any more" : "count again", e.by.name());
  }
  void operator()(const mapping::RecordRefused& e) const {
    log.limited("record", "record {} of {} refused: {}", e.id.seq, e.id.log.robot.name(), e.reason);
  }
  void operator()(const mapping::DeciderPassedOver& e) const {
    log.warn("robot {} {}; the next one decides: {}", e.robot.name(),
             e.published ? "published a solution that the links refute: refused"
                         : "should have published the team's solution",
             e.published ? "look whether it runs the same version of onemap, and who has its team key"
                         : "look at it (onemapctl doctor there): it is too slow, or hangs");
  }
  void operator()(const mapping::MapFused& e) const {
    std::string names;
    for (const auto& robot : e.solution.robots) names.append(" ").append(robot.chain.robot.name());
    log.line("{} map {:016x}: reference {}, {} links used and {} refused, robots{}, {} submaps, {} blocks, {} refused",
             e.final ? "global" : "interim", e.digest, e.solution.reference.robot.name(), e.solution.links_used,
             e.solution.links_refused, names, e.submaps, e.blocks, e.blocks_refused);
    if (e.blocks_refused > 0)
      log.warn("the global map is full: {} times a block found no room; raise map.global_budget_mb or map.voxel_m",
               e.blocks_refused);
    if (e.submaps_left_out > 0)
      log.warn(
          "{} submaps are left out of the global map: one place has more than may be decoded for it; raise "
          "map.global_budget_mb",
          e.submaps_left_out);
  }
  void operator()(const mapping::MapSettled& e) const {
    if (e.blocks > 0) return;
    log.error(
        "the team's map {:016x} is EMPTY: no submap of a robot in it could be used ({} refused); look at each "
        "robot's camera and map.max_depth_m (onemapctl doctor), and that all run the same version of onemap",
        e.digest, e.submaps_refused);
  }
};

}  // namespace

std::string chain_name(const mapping::TeamLog& log, const mapping::ChainId& chain) {
  const std::string name = chain.robot.name();
  return log.present(chain.robot) == chain ? name : fmt::format("{}.{}", name, chain.incarnation);
}

void say(const mapping::TeamEvent& event, Log& log) { std::visit(Words{log}, event); }

}  // namespace onemap::daemon
