#pragma once
#include <cstddef>
#include <cstdint>

namespace onemap::fuzz {

// Plays a script of bytes to a Guard of a team whose key the script's writer has: hellos, answers, proofs, cookies,
// sealed datagrams and group beacons, raw or with the MACs and tags that make them authentic, changed at will, over
// time that passes. Ends the process when what a Guard promises does not hold: it answers with more than came, or with
// more than 1200 bytes.
void fuzz_guard(const std::uint8_t* data, std::size_t size);

}  // namespace onemap::fuzz
