#pragma once
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "comms/wire/frames.hpp"
#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// What one peer is to be told, pings and record bodies aside, and when.
class Outbox {
 public:
  static constexpr std::size_t kManyWants = 32;  // a full datagram of them does not wait
  explicit Outbox(Memory& memory = heap()) : changed_(&memory), wants_(&memory) {}

  bool beacon_due = false;
  bool have_request_due = false;
  bool status_echo_due = false;  // what it said about itself is older than what others say that it said
  RobotId status_cursor;         // where the next status frame starts
  LogId lacking_cursor;          // and what is said once more of our frontier

  // Its author lives, and somebody offers records of a later life of it: once a second, and a few times again, for it
  // answers by beginning a new life, and it is long until somebody offers them again.
  void tell_later_life(Instant now, std::uint64_t incarnation);
  void tell_later_life_again(Instant now);
  std::optional<std::uint64_t> later_life_due;

  // MASS: the amounts have changed. They are told at once, and with the next beacon again, in case they get lost.
  static constexpr unsigned kTellAmounts = 2;
  void amounts_due() { mass_due = true, amounts_left = kTellAmounts; }
  bool mass_due = false;
  unsigned amounts_left = 0;

  // HAVE: what changed since it was told. What is news to it, or what it requested, goes in several copies, a little
  // apart, when it fits one datagram: else a lost one costs a beacon's interval.
  void tell(const LogId& log, Instant at, bool is_news = false);
  void told(Instant now, std::span<const wire::HaveEntry> entries, std::size_t count, unsigned copies = 1);
  const std::pmr::set<LogId>& changed() const { return changed_; }
  bool have_due(Instant now) const { return have_at_ && *have_at_ <= now; }
  Instant last_have() const { return last_have_; }
  bool may_tell_all(Instant now);  // at most every 20 ms

  // WANT
  void want(const wire::WantEntry& entry, Instant at);
  void wanted(Instant now, std::size_t count);  // the first ones were sent
  const std::pmr::vector<wire::WantEntry>& wants() const { return wants_; }
  void want_nothing();

  bool due(Instant now) const;          // more than a beacon
  std::optional<Instant> next() const;  // something becomes due then
  void fell_silent();                   // nothing of this concerns it any longer

 private:
  std::pmr::set<LogId> changed_;
  bool has_news_ = false;
  unsigned copies_left_ = 0;  // of the last news
  std::optional<Instant> have_at_, want_at_;
  Instant last_have_{}, next_full_have_{}, later_life_again_{};
  std::uint64_t later_life_ = 0;
  unsigned later_life_left_ = 0;  // times that it is told again
  std::pmr::vector<wire::WantEntry> wants_;
};

}  // namespace onemap::comms
