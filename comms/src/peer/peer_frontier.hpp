#pragma once
#include <cstdint>
#include <optional>

#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "memory/log_map.hpp"

namespace onemap::comms {

// What one peer holds, gathered from its HAVE frames, beside the digest of what it says that it holds. While they
// differ, something was lost, and its whole frontier is requested, at sensible times.
class PeerFrontier {
 public:
  using Logs = LogMap<std::uint32_t>;
  explicit PeerFrontier(Memory& memory = heap()) : logs_(memory) {}
  std::uint32_t count(const LogId& log) const;  // 0: nothing
  const Logs& logs() const { return logs_; }
  bool raise(const LogId& log, std::uint32_t count);  // true: more than before
  void refused_some();                                // an entry is not kept: the digests will differ for long
  // What it said of lives of this robot after that one is forgotten, and so told and judged again.
  void doubt(const RobotId& robot, std::uint64_t after);
  void judge_again(Instant now);  // what was refused may be welcome now: ask for it soon

  // In the datagram with this (unfolded) counter. Claims that were overtaken do not count.
  void claim(Instant now, std::uint64_t datagram, std::uint64_t digest, Duration round_trip);
  std::uint64_t claimed_digest() const { return claimed_; }

  std::optional<Instant> next_request() const { return request_at_; }
  // True: it was requested so often in vain that something gathered must be wrong (a count that was never true cannot
  // be lowered again): all of it is forgotten, and gathered anew.
  bool requested(Instant now, Duration round_trip);
  void be_patient_again() { requests_ = 0; }
  void ask_no_more() { request_at_.reset(); }

 private:
  Instant not_too_often(Instant request) const;
  Logs logs_;
  std::uint64_t digest_ = 0;
  std::uint64_t claimed_ = 0, claimed_in_ = 0;
  std::optional<Instant> request_at_;
  unsigned requests_ = 0;  // in a row, without success
  Instant last_request_{};
  bool refused_some_ = false;  // since the last request
};

}  // namespace onemap::comms
