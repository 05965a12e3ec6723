#pragma once
#include <cstdint>

namespace onemap::mapping {

// The typed bodies of the records that robots exchange (comms sees only bytes). One canonical encoding each: little
// endian, integers only, bounded, versioned by the kind. decode() is total: any bytes give a value or an error that
// names the field; encode(decode(x)) == x. For submaps and keyframes that holds for the content of the compressed part:
// the compressed bytes themselves may differ between versions of zstd, and every version accepts every other's.
// encode() expects a record that keeps the bounds stated here; what breaks them is refused by decode().
enum class RecordKind : std::uint16_t {
  hello = 1,
  keyframe = 2,
  trajectory = 3,
  submap = 4,
  link = 5,
  solution = 6,
  finished = 7,
  frontier = 8,
  ruling = 9
};

// Lanes keep small and urgent records from waiting behind large ones; lower goes first.
enum class Lane : std::uint8_t { control = 0, poses = 1, features = 2, voxels = 3 };

}  // namespace onemap::mapping
