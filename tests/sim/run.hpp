#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "sim/scenario.hpp"

namespace onemap::comms::sim {

// What became of a scenario.
struct Outcome {
  std::string failure;  // which invariant broke, or what did not happen; empty: all is well
  Duration recovery{};  // from the end of the faults until all honest robots held the same
  Duration bound{};     // the shortest time in which links and air, with their delays, carry what was missing
  Duration time{};      // that went by in the net
  std::uint64_t datagrams = 0, looks = 0, records = 0;
  std::uint64_t digest = 0;  // of all that happened: equal for equal runs
};

// Plays it: first with all faults, and invariants only (safety); then everything is well, and all honest robots have to
// hold the same records within 1.5 times the bound and 2 seconds (liveness), and more
// while somebody hostile lies to them, or has just gone. Where it lives under a robot's name nothing can be demanded
// before it has gone.
// `trace` hears of each datagram that arrives, in words.
using Trace = std::function<void(const std::string& line)>;
Outcome run(const Scenario& scenario, const Trace& trace = {});

// The least of it that still fails, by leaving out faults, writes and properties of the links one after another. The
// scenario must fail.
Scenario shrink(Scenario scenario);

}  // namespace onemap::comms::sim
