#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "hal/base/ids.hpp"

namespace onemap::comms {

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

// An immutable record. The body is opaque to comms.
struct Record {
  RecordId id;
  std::uint16_t kind = 0;
  std::vector<std::uint8_t> body;
};

// How many records of each log are held without a gap: the frontier of a record set.
using VersionVector = std::map<LogId, std::uint32_t>;

// 64-bit digest of a version vector, equal on equal vectors: the sum over all logs that are not empty of entry_digest,
// modulo 2^64, so that it can be kept up to date entry by entry.
std::uint64_t entry_digest(const LogId& log, std::uint32_t count);  // 0 when count is 0
std::uint64_t digest(const VersionVector& frontier);

// Where records are kept. Append in order of sequence; a record is never changed.
class LogStore {
 public:
  virtual ~LogStore() = default;
  virtual bool append(Record record) = 0;  // false: not the next of its log, or no room
  virtual std::shared_ptr<const Record> find(const RecordId& id) const = 0;
  virtual const VersionVector& frontier() const = 0;
  virtual std::size_t bytes() const = 0;
};

}  // namespace onemap::comms
