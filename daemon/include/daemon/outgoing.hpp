#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "mapping/records/kind.hpp"

namespace onemap::daemon {

// A record of this robot on its way into its log.
struct OutgoingRecord {
  mapping::Lane lane = mapping::Lane::control;
  mapping::RecordKind kind = mapping::RecordKind::hello;
  std::vector<std::uint8_t> body;
};

// Takes a record for the log; may be called from any thread and never waits for the network.
using Publish = std::function<void(OutgoingRecord)>;

}  // namespace onemap::daemon
