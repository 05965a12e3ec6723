#pragma once
#include <cstdint>

#include "memory/log_map.hpp"

namespace onemap::comms {

// How many records of each log the store holds: what its frontier says, found faster, because it is asked for every
// log that a neighbour names.
class HeldLogs {
 public:
  explicit HeldLogs(Memory& memory = heap()) : counts_(memory) {}
  void start(const VersionVector& frontier) {
    for (const auto& [log, count] : frontier) counts_[log] = count;
  }
  void took(const RecordId& id) { counts_[id.log] = id.seq + 1; }
  std::uint32_t count(const LogId& log) const {
    const std::uint32_t* const known = counts_.find(log);
    return known == nullptr ? 0 : *known;
  }

 private:
  LogMap<std::uint32_t> counts_;
};

}  // namespace onemap::comms
