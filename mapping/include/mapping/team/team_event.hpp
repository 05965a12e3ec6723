#pragma once
#include <string>
#include <variant>

#include "mapping/records/finished.hpp"
#include "mapping/records/kind.hpp"
#include "mapping/records/link.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/team/team_member.hpp"

// What happened in the team, for people: the daemon finds the words.
namespace onemap::mapping {

struct RobotJoined {  // its first valid Hello of this life
  RobotId robot;
  std::string camera;
};
struct RobotFinished {
  RobotId robot;
  FinishedRecord record;
};
struct RobotGone {  // is not waited for any more
  RobotId robot;
  Duration silent{};
};
struct RobotBack {  // was gone
  RobotId robot;
};
struct LinkLooked {  // somebody looked at a pair; link.reason says whether they are linked
  ChainId author;
  LinkRecord link;
  bool again = false;  // this robot itself, and refused for the same reason as the last time
};
struct PairRuled {  // a person said whether links of a pair (a = b: own loops) count
  RobotId by;
  RulingRecord ruling;
};
struct RecordRefused {
  RecordId id;
  std::uint16_t kind = 0;
  std::string reason;
};
struct DeciderPassedOver {  // it should have published the team's solution, and did not, or one that the links refute
  RobotId robot;
  bool published = false;
};
struct MapFused {
  bool final = false;  // from all that will come
  std::uint64_t digest = 0;
  SolutionRecord solution;
  std::size_t submaps = 0, submaps_left_out = 0, blocks = 0;
  std::uint64_t blocks_refused = 0;
};
struct MapSettled {
  std::uint64_t digest = 0;
  std::size_t blocks = 0;
  std::uint64_t submaps_refused = 0;
};
using TeamEvent = std::variant<RobotJoined, RobotFinished, RobotGone, RobotBack, LinkLooked, PairRuled, RecordRefused,
                               DeciderPassedOver, MapFused, MapSettled>;

// A record that this robot has to write.
struct TeamRecord {
  Lane lane = Lane::poses;
  RecordKind kind = RecordKind::link;
  std::vector<std::uint8_t> body;
};

}  // namespace onemap::mapping
