#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"
#include "peer/round_trip.hpp"

namespace onemap::comms {

// Fragments that were asked of one peer and have not come. A peer serves a lane in the order of asking, so later
// answers make earlier asks suspect; and lower lanes go first, so silence in them all means that nothing is coming.
class AskLedger {
 public:
  struct Fragment {
    RecordId id;
    std::uint32_t index = 0;
  };
  using Fragments = std::pmr::vector<Fragment>;
  explicit AskLedger(Memory& memory = heap()) : lanes_(of_each_lane<Lane>(memory)), memory_(&memory) {}
  // `serial` is unique within the node.
  void add(Instant now, const Fragment& fragment, std::uint32_t serial);
  void answered(Instant now, std::uint8_t lane, std::uint32_t serial);
  void progressed(Instant now, std::uint8_t lane);                     // something came in this lane
  void withdraw(const RecordId& id, std::uint32_t from_fragment = 0);  // from this one on
  void clear();

  // What is to be asked for again: overtaken by three answers, and the reorder window has passed since; or all of a
  // lane after silence, which is counted.
  Fragments take_overtaken(Instant now, std::uint8_t lane, Duration reorder_window);
  Fragments take_silent(Instant now, std::uint8_t lane, const RoundTrip& round_trip);
  Instant next_deadline(const RoundTrip& round_trip) const;

  std::size_t outstanding() const;
  bool may_ask_bulk = true;                        // its window has opened enough to be filled again
  unsigned silences() const { return silences_; }  // in a row
  void is_there();                                 // it was heard: do not wait for seconds
  bool avoided(Instant now) const { return avoid_until_ > now; }
  void avoid(Instant now) { avoid_until_ = now + kAvoid; }

 private:
  static constexpr auto kAvoid = std::chrono::seconds(1);
  struct Ask {
    Fragment fragment;
    std::uint32_t serial = 0;
    bool done = false;                    // answered, given up or no longer needed
    std::uint8_t overtaken = 0;           // later asks that were answered
    std::optional<Instant> overtaken_at;  // when that became enough to suspect a loss
  };
  struct Lane {
    explicit Lane(Memory* memory) : asks(memory) {}
    std::pmr::deque<Ask> asks;             // in order of asking; done ones are dropped from the front
    std::size_t outstanding = 0;           // of them, not done
    Instant progress{};                    // last answer here or in a lower lane, or the first ask after idleness
    std::optional<Instant> suspect_since;  // the earliest overtaken_at
  };
  static void finish(Lane& lane, Ask& ask);
  static void trim(Lane& lane);
  std::array<Lane, kLaneCount> lanes_;
  Memory* memory_;
  unsigned silences_ = 0;
  Instant avoid_until_{};
};

}  // namespace onemap::comms
