#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/time.hpp"
#include "mapping/records/chain_id.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/ruling.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/team/keyframe_log.hpp"
#include "mapping/team/long_way.hpp"
#include "mapping/team/recent_frontiers.hpp"
#include "mapping/team/record_ptr.hpp"
#include "mapping/team/submap_log.hpp"

namespace onemap::mapping {

// One robot of the team by its records of one life. What is large stays encoded, in the bodies that the store holds
// anyway: a robot costs here a pointer a record, a pose a keyframe and its way, whatever its records would decode to.
// Where the store is on a disk, voxels stay there.
struct TeamMember {
  static constexpr std::size_t kMaxLinks = 512, kMaxRulings = 512;  // beyond: refused
  static constexpr std::size_t kMostPoses = 1u << 18;               // 5.5 MB; of a longer way fewer are kept

  std::uint64_t incarnation = 0;  // of the life that these records are from
  std::string name, camera;       // no name: no valid Hello yet, so this life does not count; camera is printable
  std::uint64_t repeats = 0;      // the earlier life whose records these are again; 0: none
  std::uint32_t map_blocks = 0;   // as many its global map can hold; 0: not said
  std::optional<FinishedRecord> finished;
  KeyframeLog keyframes;  // all of them
  SubmapLog submaps;      // all of them
  // Its way, in its own frame, in order of its log. Decoded: a thousand small bodies would be in as many places.
  LongWay trajectory{kMostPoses};
  std::size_t keyframes_refused = 0;       // beyond what is looked at: they count for completeness, and nothing else
  bool poses_refused = false;              // some are missing for good
  std::optional<SolutionRecord> solution;  // the last one that it published
  std::uint64_t solution_digest = 0;       // its digest()
  RecentFrontiers frontiers;
  std::map<ChainId, LinkRecord> links;  // the last one that it published of each pair, by the other chain
  std::map<std::pair<ChainId, ChainId>, RulingRecord> rulings;  // the last one that it published of each pair
  Instant heard{};                                              // when its last record came

  // Takes a record of this robot. The error says what is malformed; then nothing but the counts above changed.
  Status apply(const RecordPtr& record);

  bool counts() const { return !name.empty(); }
  bool keyframes_complete() const { return finished && keyframes.size() + keyframes_refused >= finished->keyframes; }
  bool complete() const {
    return keyframes_complete() && submaps.size() >= finished->submaps &&
           (poses_refused || trajectory.added() >= finished->tracked);
  }
};

}  // namespace onemap::mapping
