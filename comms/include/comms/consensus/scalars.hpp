#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/base/ids.hpp"

// What a team agrees on while it works, over any number of hops, without anybody who decides. (The map is not among it:
// ARCHITECTURE.md says why.)
namespace onemap::comms {

enum class Scalar : std::uint8_t {
  clock_offset,  // s: how far a robot's wall clock is ahead of the team's mean one
  brightness,    // of a camera's images, 0..255: what a colour gain is made of
  team_size,     // robots
  count
};
inline constexpr std::size_t kScalars = static_cast<std::size_t>(Scalar::count);
std::string_view name(Scalar which);

struct ScalarValue {
  double own = 0.0;     // what this robot brought
  double agreed = 0.0;  // the mean over the team (of team_size, the sum), as far as it is known here
  bool known = false;   // somebody brought something, and it has come here
};

struct ScalarsView {
  std::uint64_t round_of_talks = 0;  // 0: none began yet. All who take part in one name it alike
  std::uint64_t exchanges = 0;       // in it, so far
  bool settled = false;              // nothing has changed for some exchanges
  std::array<ScalarValue, kScalars> values;
};

}  // namespace onemap::comms
