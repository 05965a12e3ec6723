#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "sim/field.hpp"
#include "sim/sim_net.hpp"

namespace onemap::comms::sim {

// Kinds of records, by how long their bodies count.
inline constexpr std::uint16_t kAlways = 1, kUntilTheNext = 2, kUntilItMayGo = 3;

struct Write {
  Duration at{};
  std::size_t robot = 0;
  std::uint8_t lane = 0;
  std::size_t bytes = 0;
  std::uint16_t kind = kAlways;
};

struct Fault {
  enum class Kind : std::uint8_t {
    partition,    // `side` does not hear the others, and is not heard by them unless `one_way`
    clog,         // what `robot` sends to `other` waits
    crash,        // power off, and on again in a later life
    wipe,         // and the disk is empty, too
    forget_life,  // and the number of its life is an earlier one
    stop,         // its process does not run
    clock_jump,   // its clock goes ahead by `lasts`
    storm,        // most datagrams are lost, everywhere
    full_disk     // it takes nothing more
  };
  Kind kind{};
  Duration at{}, lasts{};
  std::size_t robot = 0, other = 0;
  std::vector<bool> side;
  bool one_way = false;
  double loss = 0.0;
};

// All that happens to a team, but for what chance makes of it on the links. One seed, one scenario.
struct Scenario {
  std::uint64_t seed = 0;
  std::size_t robots = 2;
  std::vector<Edge> edges;
  LinkModel links;
  Medium::Model air;
  Field::Model field;  // when its reach is not 0, `edges` is not used
  NodeConfig node;
  bool disks = false;          // the daemon's log, else records die with the process
  unsigned sync_polls = 0;     // looks at the disk that a sync takes
  bool sealed = false;         // the team has a key
  bool hostile = false;        // somebody who lies is among them
  bool hostile_stays = false;  // after the faults, too
  std::vector<Write> writes;
  std::vector<Fault> faults;
  Duration chaos{};  // that long; then everything is well
};

struct Size {
  std::size_t least_robots = 2, most_robots = 6;
  Duration least = std::chrono::seconds(3), most = std::chrono::seconds(12);
  std::size_t most_faults = 6;
  std::size_t writes_of_robot = 8;
};
Scenario scenario_of(std::uint64_t seed, const Size& size = {});
std::string text_of(const Scenario& scenario);  // some lines, for people
std::string text_of(const Fault& fault);

}  // namespace onemap::comms::sim
