#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "comms/consensus/running_sums.hpp"
#include "comms/consensus/scalars.hpp"
#include "comms/counters.hpp"
#include "comms/record_head.hpp"
#include "comms/status.hpp"
#include "hal/base/record.hpp"

// What a datagram says (comms/PROTOCOL.md): frames of type u8, length u16, body.
namespace onemap::comms::wire {

inline constexpr std::size_t kFrameHeadBytes = 3;
inline constexpr std::size_t kFragmentBytes = 1112;  // of a record's payload; only the last fragment is shorter
inline constexpr std::uint8_t kLastPushedLane = 1;   // control and poses do not wait to be asked for
inline constexpr std::size_t kMaxPayloadBytes = kMaxRecordBytes + kSealBytes;
inline constexpr std::uint8_t kFirstSkippableType = 128;

struct Beacon {
  RobotId robot;
  std::uint64_t frontier_digest = 0, map_digest = 0;
  std::uint32_t status_counter = 0;
  std::uint8_t flags = 0;
  bool operator==(const Beacon&) const = default;
};
struct HaveEntry {
  LogId log;
  std::uint32_t count = 0;  // at least 1
  bool operator==(const HaveEntry&) const = default;
};
struct WantEntry {
  RecordId id;
  std::uint16_t first = 0, count = 0;  // fragments; what lies behind the record's end is not meant
  bool operator==(const WantEntry&) const = default;
};

// Decoded frames. The spans point into the decoder's own lists or into the datagram.
struct Status {
  std::span<const RobotStatus> robots;
};
struct Have {
  std::uint64_t frontier_digest = 0;  // of all that the sender holds, not only of these entries
  std::span<const HaveEntry> entries;
};
struct HaveRequest {};
struct Want {
  std::uint32_t credit_bytes = 0;  // how much may wait for the asker at the server, these entries included
  std::span<const WantEntry> entries;
};
struct Data {
  RecordId id;
  std::uint16_t kind = 0;
  std::uint8_t hops = 0;          // links that the sender's copy came over
  std::uint32_t total_bytes = 0;  // of the payload: the body and then the seal
  std::uint64_t body_hash = 0;    // body_hash(kind, payload)
  std::uint16_t fragment = 0;
  std::span<const std::uint8_t> bytes;
};
// A record whose body was dropped at the sender: all that its signature covers, with the body's digest; and the same of
// the later record of its log and kind that took its place, which proves that it may be dropped.
struct Head {
  RecordHead record;
  std::uint8_t hops = 0;  // links that the sender's copy came over
  Signature signature{};
  SignedHead by;  // its log and kind are the record's
};
struct Ping {
  std::uint32_t token = 0;
};
struct Pong {
  std::uint32_t token = 0;
};
// What came here from who is told, while it sends data (see Arrivals). Counts and clock go round.
struct Feedback {
  std::uint32_t highest = 0;   // counter of the latest datagram that came
  std::uint32_t received = 0;  // datagrams that came, each once, since it became known
  std::uint32_t clock_us = 0;  // of who tells, of any beginning, when the latest came
  std::uint32_t delay_us = 0;  // since then
  bool operator==(const Feedback&) const = default;
};
// Somebody who holds records of a later life of `robot` tells it so.
struct LaterLife {
  RobotId robot;
  std::uint64_t incarnation = 0;
  bool operator==(const LaterLife&) const = default;
};
// How the link is from here, and what goes to and fro in the team's talks (Talks, RunningSums).
struct Mass {
  std::uint16_t heard = 0;  // share of the receiver's datagrams that come here, in 65535ths; 0: not known
  std::uint8_t neighbours = 0;
  std::uint64_t round = 0;    // of talks; 0: none, and no amounts
  std::int64_t clock_ns = 0;  // of who began the round, when this was sent
  bool has_amounts = false;
  std::array<comms::Mass, kScalars> given;  // to the receiver, since the round began
};
using Frame = std::variant<Beacon, Status, Have, HaveRequest, Want, Data, Ping, Pong, Feedback, LaterLife, Head, Mass>;
FrameType type_of(const Frame& frame);

inline constexpr std::size_t kBeaconBytes = 37;
inline constexpr std::size_t kStatusEntryBytes = 45;
inline constexpr std::size_t kHaveEntryBytes = 29, kHaveFixedBytes = 8;
inline constexpr std::size_t kWantEntryBytes = 33, kWantFixedBytes = 4;
inline constexpr std::size_t kDataFixedBytes = 46;
inline constexpr std::size_t kFeedbackBytes = 16;
inline constexpr std::size_t kLaterLifeBytes = 24;
inline constexpr std::size_t kMassFixedBytes = 19, kMassAmountsBytes = 16 * kScalars;
inline constexpr std::size_t kHeadFrameBytes = 304;

constexpr std::uint32_t fragments_of(std::uint32_t total_bytes) {
  return std::max<std::uint32_t>(1, (total_bytes + kFragmentBytes - 1) / kFragmentBytes);
}
// XXH3-64 of the payload with the kind as the seed.
std::uint64_t body_hash(std::uint16_t kind, std::span<const std::uint8_t> payload);

}  // namespace onemap::comms::wire
