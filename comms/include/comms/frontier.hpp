#pragma once
#include <cstdint>

#include "hal/base/record.hpp"

namespace onemap::comms {

// 64-bit digest of a version vector, equal on equal vectors: the sum over all logs that are not empty of entry_digest,
// modulo 2^64, so that it can be kept up to date entry by entry.
std::uint64_t entry_digest(const LogId& log, std::uint32_t count);  // 0 when count is 0
std::uint64_t digest(const VersionVector& frontier);

}  // namespace onemap::comms
