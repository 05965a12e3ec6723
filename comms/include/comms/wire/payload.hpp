#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "comms/wire/frames.hpp"

// What DATA carries of a record: its body and then its seal, cut into fragments of kFragmentBytes.
namespace onemap::comms::wire {

inline std::uint32_t payload_bytes(const Record& record) {
  return static_cast<std::uint32_t>(record.body.size() + kSealBytes);
}
std::uint64_t payload_hash(const Record& record);

using FragmentBuffer = std::array<std::uint8_t, kFragmentBytes>;
// One fragment's bytes: in the body, or gathered in `scratch` where it ends.
std::span<const std::uint8_t> fragment_of(const Record& record, std::uint32_t fragment, FragmentBuffer& scratch);
// Takes a whole payload apart; it has at least a seal.
void take_apart(std::span<const std::uint8_t> payload, Record& record);

}  // namespace onemap::comms::wire
