#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "mapping/team/team_event.hpp"

namespace onemap::daemon {

// What became of pairs of robots that somebody looked at, since this robot was started.
struct LinkTally {
  static constexpr std::size_t kReasons = 12;    // of mapping::LinkReason; the last: of a later version
  std::array<std::uint64_t, kReasons> looked{};  // by reason; [0]: accepted
  std::uint64_t own_loops = 0;                   // places that a robot came back to, as its last word has it
  std::uint64_t maps_fused = 0, records_refused = 0, deciders_passed_over = 0;

  void add(const mapping::TeamEvent& event);
  std::uint64_t proposed() const;
  static std::string reason(std::size_t index);  // as a word: "accepted", "too_few_matches", ...
};

}  // namespace onemap::daemon
