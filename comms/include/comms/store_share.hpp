#pragma once
#include <cstddef>

#include "hal/base/record.hpp"

namespace onemap::comms {

inline constexpr std::uint8_t kFirstBulkLane = 2;   // features, voxels, imagery
inline constexpr std::uint8_t kFirstVoxelLane = 3;  // voxels, imagery
inline bool is_bulk(const LogId& log) { return log.lane >= kFirstBulkLane; }

// Of a store's room so much is for records like this one. Voxels leave the last tenth to features, without which they
// have no place, and these its half to control and poses, and to what does little but name a record that it makes
// needless, for that makes room.
inline std::size_t share_for(const Record& record, std::size_t room) {
  constexpr std::size_t kLittle = 96;  // bytes of a body
  const bool makes_room = record.seal.replaces < record.id.seq && record.body.size() <= kLittle;
  if (!is_bulk(record.id.log) || makes_room) return room;
  return room - room / (record.id.log.lane < kFirstVoxelLane ? 20 : 10);
}

// What a refusal says of it; empty: all the room is for records of this log.
inline const char* what_is_left(const LogId& log) {
  if (!is_bulk(log)) return "";
  return log.lane < kFirstVoxelLane ? ", the last twentieth is for control and poses"
                                    : ", the last tenth is for control, poses and features";
}

}  // namespace onemap::comms
