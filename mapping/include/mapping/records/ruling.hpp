#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/records/chain_id.hpp"

namespace onemap::mapping {

// What a person said of a pair of chains, or of one chain's own loops (a = b): that they do not belong together,
// whatever was verified, or that this no longer holds. Anybody in the team may write it; of all that were written of a
// pair the one with the highest turn counts, and of equal ones that of the highest author.
struct RulingRecord {  // lane poses
  ChainId a, b;        // a <= b
  bool apart = true;
  std::uint32_t turn = 1;  // one more than the highest that its author knew of this pair; 1 to 2^31
  bool operator==(const RulingRecord&) const = default;
};

inline constexpr std::uint32_t kMostTurns = 1u << 31;

std::vector<std::uint8_t> encode(const RulingRecord& record);
Result<RulingRecord> decode_ruling(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
