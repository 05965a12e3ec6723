#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "hal/base/ids.hpp"

// The envelope of a record: what carries it (comms) and what reads it (mapping) both know, and nothing more.
namespace onemap {

// Lanes 0..4: control, poses, features, voxels, imagery. A lower lane is always asked for and served first.
inline constexpr std::uint8_t kLaneCount = 5;
inline constexpr std::size_t kMaxRecordBytes = 1u << 20;  // of one body

// Which log: a robot writes one append-only log a lane and incarnation. An incarnation is one life of a robot whose
// logs lived in memory: it starts again with sequence 0 and a greater incarnation, so a sequence number is never used
// twice. Logs of older incarnations stay and replicate like any other; who applies records decides what they are worth.
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

// An immutable record. Who carries it does not look into the body.
struct Record {
  RecordId id;
  std::uint16_t kind = 0;
  std::vector<std::uint8_t> body;
};

// How many records of each log are held without a gap: the frontier of a record set.
using VersionVector = std::map<LogId, std::uint32_t>;

}  // namespace onemap
