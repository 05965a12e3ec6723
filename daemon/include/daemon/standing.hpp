#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/pipeline.hpp"
#include "daemon/radio.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

// Where this robot stands with its team.
struct Standing {
  bool agreed = false;  // own work done, and all robots that are not gone hold one map
  bool stuck = false;   // what is waited for cannot come by itself
  std::string waiting;  // for what, in words; empty: for nothing
};

// What was refused so far, by reason: datagrams and records by the radio, records and map blocks by the team.
std::map<std::string, std::uint64_t> refusals(const TeamView& team, const RadioView& radio);

// From what the parts say about themselves; a robot alone agrees with itself. A pure function.
Standing standing(const PipelineProgress& progress, const TeamView& team, const RadioView& radio);

}  // namespace onemap::daemon
