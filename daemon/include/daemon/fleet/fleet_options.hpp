#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/fleet/link_emulator.hpp"
#include "daemon/fleet/link_graph.hpp"
#include "daemon/options.hpp"

namespace onemap::daemon {

struct FleetConfig {
  std::vector<std::string> cameras;  // one a robot; robot1, robot2, ... in this order
  std::vector<FleetLink> links;
  LinkFaults faults;
  std::string speed = "max";
  std::string features;               // empty: the daemon's default
  std::string robot_config;           // TOML for every robot; empty: none
  std::uint64_t matches_picture = 0;  // frames from one picture of a robot's matches to the next; 0: none
  std::string team_key;               // file; empty: none, and everything is plain
  double timeout_s = 600;
  std::string out;
};

// `0.1` or `10%`; 0 up to, not including, 1.
Result<double> parse_loss(const std::string& text);

// onemap-fleet's command line.
Parsed<FleetConfig> parse_fleet_options(const std::vector<std::string>& arguments);

std::string fleet_robot_name(std::size_t number);  // number from 0: robot1, ...

}  // namespace onemap::daemon
