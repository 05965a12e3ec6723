#pragma once
#include <cstdint>
#include <map>

#include "comms/status.hpp"
#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// The robots that count: this one, those of whom records are here, and living neighbours; and the newest word of each
// about itself. Hearsay about anybody else is not kept: a robot that is real writes a record, and that travels.
class TeamTable {
 public:
  // Room for max_robots; some of it is for neighbours alone.
  TeamTable(const RobotId& self, std::uint64_t incarnation, std::size_t max_robots, std::size_t max_neighbours,
            Memory& memory = heap());

  enum class Merge {
    newer,       // and kept
    known,       // nothing new
    older,       // than what is known of this very life
    unknown,     // it does not count, or this life of it does not
    about_self,  // a later word of ours than we remember: from now on we count on from there
    later_self   // a later life of ours
  };
  Merge merge(const RobotStatus& status, Instant now);
  // A robot's present life is a neighbour; it must not be this robot. It counts from now on, if there is room.
  void met(const RobotId& robot, std::uint64_t incarnation, Instant now);
  void left(const RobotId& robot);  // it is no neighbour any more, and counts only if there are records
  void recorded(const LogId& log, bool first_of_log, Instant now);  // one record more is here
  void start(Instant now);  // who was known before the clock was heard shows its sign of life now

  bool room_for(const RobotId& robot, bool neighbour) const;
  std::size_t logs_of(const RobotId& robot) const;
  std::uint64_t life_in_records(const RobotId& robot) const;  // the latest of which a record is here; 0: none
  Instant last_sign(const RobotId& robot) const;

  bool set_own(std::uint64_t frontier_digest, std::uint64_t map_digest, std::uint8_t flags);  // true: changed
  const RobotStatus& say_own();  // own entry as it goes out: what is said twice under one counter is equal
  const std::pmr::map<RobotId, RobotStatus>& robots() const { return robots_; }
  const RobotStatus& own() const { return robots_.find(self_)->second; }

 private:
  struct Trace {
    std::size_t logs = 0;
    std::uint64_t life = 0;  // latest in records
    Instant last_sign{};
  };
  RobotStatus& mine() { return robots_.find(self_)->second; }
  RobotStatus& entry(const RobotId& robot, std::uint64_t incarnation);
  RobotId self_;
  std::size_t max_robots_, for_neighbours_;
  bool unsaid_ = true;
  std::pmr::map<RobotId, RobotStatus> robots_;
  std::pmr::map<RobotId, Trace> traces_;
};

}  // namespace onemap::comms
