#include "daemon/standing.hpp"

#include <fmt/format.h>

namespace onemap::daemon {

namespace {

std::string words(const Waiting& waiting) {
  using What = Waiting::What;
  switch (waiting.what) {
    case What::records:
      return "its records";
    case What::end:
      return "its end";
    case What::link:
      return "its links";
    case What::solution:
      return "the team's solution";
  }
  return "it";
}

// "r2 (its records), silent for 12 s; r3 (its end)"
std::string list(const std::vector<Waiting>& all) {
  std::string text;
  for (const Waiting& waiting : all) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : "; ", waiting.robot.name(), words(waiting));
    const auto silent = std::chrono::duration_cast<std::chrono::seconds>(waiting.silent);
    if (silent >= std::chrono::seconds(5)) text += fmt::format(", silent for {} s", silent.count());
  }
  return text;
}

bool equal_everywhere(const TeamView& team, const RadioView& radio) {
  return team.settled && radio.agrees && radio.agreed_digest == team.digest;
}

}  // namespace

std::map<std::string, std::uint64_t> refusals(const TeamView& team, const RadioView& radio) {
  auto all = radio.refused;
  const auto add = [&](const char* reason, std::uint64_t count) {
    if (count > 0) all[reason] += count;
  };
  add("malformed_record", team.records_refused);
  add("submap_beyond_budget", team.submaps_left_out);
  add("submap_unread", team.submaps_unread);
  add("global_block_without_room", team.blocks_refused);
  add("block_without_anchor", team.blocks_unplaced);
  return all;
}

Standing standing(const PipelineProgress& progress, const TeamView& team, const RadioView& radio) {
  Standing out;
  if (!progress.finished) return out;
  out.agreed = equal_everywhere(team, radio);
  if (!radio.store_full.empty() && !out.agreed) {
    out.stuck = true;
    out.waiting = radio.store_full;
  } else if (team.submaps_unread > 0 && !out.agreed) {
    out.stuck = true;
    out.waiting = fmt::format("{} submaps of the map cannot be read from the log: look at the disk under OUT/log",
                              team.submaps_unread);
  } else if (!team.waiting.empty()) {
    out.waiting = "waiting for " + list(team.waiting);
  } else if (!team.settled) {
    out.waiting = "waiting for the map to be merged";
  } else if (!out.agreed) {
    out.waiting = "waiting for the other robots to hold the same map";
  }
  return out;
}

}  // namespace onemap::daemon
