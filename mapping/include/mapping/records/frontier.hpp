#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/records/chain_id.hpp"

namespace onemap::mapping {

// How far one chain's records count: its first so many.
struct ChainExtent {
  ChainId chain;
  std::uint32_t keyframes = 0, submaps = 0;
  bool operator==(const ChainExtent&) const = default;
};

// Which records the map of a solution is made of while robots still write: whoever holds them can make that map, byte
// for byte. Written by the elected robot, now and then; the last one counts.
struct FrontierRecord {             // lane poses
  std::uint64_t solution = 0;       // digest() of the solution that it belongs to
  std::vector<ChainExtent> chains;  // of the solution's, sorted; at most 1024
  bool operator==(const FrontierRecord&) const = default;
};

std::vector<std::uint8_t> encode(const FrontierRecord& record);
Result<FrontierRecord> decode_frontier(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
