#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "hal/base/ids.hpp"

// The envelope of a record: what carries it (comms) and what reads it (mapping) both know, and nothing more.
namespace onemap {

// Lanes 0..4: control, poses, features, voxels, imagery. A lower lane is always asked for and served first.
inline constexpr std::uint8_t kLaneCount = 5;
inline constexpr std::size_t kMaxRecordBytes = 1u << 20;  // of one body

// Which log: a robot writes one append-only log a lane and incarnation. An incarnation is one life of a robot: it
// starts again with sequence 0 and a greater incarnation, so a sequence number is never used twice. Logs of older
// incarnations stay and replicate like any other; who applies records decides what they are worth.
struct LogId {
  RobotId robot;
  std::uint8_t lane = 0;
  std::uint64_t incarnation = 0;
  auto operator<=>(const LogId&) const = default;
};

// Which record: sequence numbers of a log start at 0 and have no gaps.
struct RecordId {
  LogId log;
  std::uint32_t seq = 0;
  auto operator<=>(const RecordId&) const = default;
};

// No record: of a log's sequences the one that is never reached.
inline constexpr std::uint32_t kNoSequence = 0xFFFFFFFFu;

// What makes a record its author's (comms/record_head.hpp): its place behind its predecessor, which earlier one it
// makes needless, and a signature.
struct Seal {
  std::array<std::uint8_t, 32> previous{};  // hash of the head before it; of a log's first record: the author's key
  // An earlier record of this log, of the same kind, that nobody needs once this one and what is between them is here.
  std::uint32_t replaces = kNoSequence;
  std::array<std::uint8_t, 64> signature{};
  bool operator==(const Seal&) const = default;
};

// What is left of a body that was dropped, because later records say all that it said.
struct DroppedBody {
  std::uint32_t bytes = 0;
  std::array<std::uint8_t, 32> digest{};  // BLAKE2b-256
  bool operator==(const DroppedBody&) const = default;
};

// An immutable record. Who carries it does not look into the body.
struct Record {
  RecordId id;
  std::uint16_t kind = 0;
  std::vector<std::uint8_t> body;
  Seal seal{};
  std::optional<DroppedBody> dropped{};  // then the body is empty
};

// How many records of each log are held without a gap: the frontier of a record set.
using VersionVector = std::map<LogId, std::uint32_t>;

}  // namespace onemap
