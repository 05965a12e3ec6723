#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "hal/base/time.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// Which of this robot's voxel records nobody needs any more, because it has been there again: its log grows with the
// area and not with the time. A record is needless when each of its blocks went out again for the same anchor, or when
// what it saw has been seen at least as well since, by submaps that were begun a minute or more after the camera had
// left this one. Where that is follows from the solution, so loops must have been closed. Used by one thread.
class NeedlessSubmaps {
 public:
  explicit NeedlessSubmaps(ReadRecord read = {}) : read_(std::move(read)) {}  // of records that are held without bodies

  // Of the records of this life those that are needless and were not named before, by their sequences, the oldest
  // first. Reads and decodes each record once; one that cannot be read is needed.
  std::vector<std::uint32_t> look(const TeamMember& own, const SolvedRobot& solved);

 private:
  struct Piece {  // of a submap: a block
    BlockKey key;
    std::uint32_t evidence = 0;  // sum of its voxels' weights
  };
  struct Kept {
    std::uint32_t sequence = 0, anchor = 0;
    double block_m = 0;
    std::vector<Piece> pieces;  // that did not go out again, sorted by key
  };
  // When the camera was in a submap, and where that is.
  struct Visit {
    FrameTime begin{}, end{};
    std::optional<Pose> T_map_anchor;
  };
  using Visits = std::map<std::uint32_t, Visit>;  // by anchor
  struct Placed {
    const Kept* kept = nullptr;
    const Visit* visit = nullptr;
  };
  class Evidence;
  static Visits visits(const TeamMember& own, const SolvedRobot& solved);
  void take(const SubmapPlace& place);
  std::vector<std::uint32_t> sent_again();
  std::vector<std::uint32_t> seen_again(const TeamMember& own, const SolvedRobot& solved);

  ReadRecord read_;
  std::uint64_t life_ = 0;
  std::size_t looked_ = 0;  // at so many of its records
  std::vector<Kept> kept_;  // in the order of the log
};

}  // namespace onemap::mapping
