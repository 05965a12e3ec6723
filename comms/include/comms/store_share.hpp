#pragma once
#include <cstddef>

#include "hal/base/record.hpp"

namespace onemap::comms {

inline constexpr std::uint8_t kFirstBulkLane = 2;  // features, voxels, imagery
inline bool is_bulk(const LogId& log) { return log.lane >= kFirstBulkLane; }

// Of a store's room so much is for records like this one: the last tenth is for control and poses, and for what does
// little but name a record that it makes needless, for that makes room.
inline std::size_t share_for(const Record& record, std::size_t room) {
  constexpr std::size_t kLittle = 96;  // bytes of a body
  const bool makes_room = record.seal.replaces < record.id.seq && record.body.size() <= kLittle;
  return is_bulk(record.id.log) && !makes_room ? room - room / 10 : room;
}

}  // namespace onemap::comms
