#pragma once
#include <map>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/local/local_mapper.hpp"
#include "mapping/team/candidates.hpp"
#include "mapping/team/survey.hpp"

namespace onemap::daemon {

// How fast a recording is played; a live camera has its own pace.
struct Speed {
  bool max = false;   // every frame, as fast as it goes
  double factor = 1;  // else: times the recording's own pace, dropping frames when the work does not keep up
};
Result<Speed> parse_speed(const std::string& text);

// What is written of the camera's frames.
struct RecordConfig {
  bool start = false;                                     // from the start on; else when somebody asks
  std::vector<std::string> formats{"tum"};                // what is written
  std::size_t limit_bytes = std::size_t{4096} << 20;      // of one recording
  std::size_t least_free_bytes = std::size_t{512} << 20;  // of the disk, left to others
};

// Pictures and models of the maps while the robot works.
struct SnapshotsConfig {
  double every_s = 0;                                      // 0: not by time
  bool on_change = false;                                  // when the map has changed
  std::size_t keep = 20;                                   // so many; the oldest go
  std::size_t disk_limit_bytes = std::size_t{1024} << 20;  // all of them together
  std::vector<std::string> views{"fit", "top"};            // of each picture
  std::vector<std::string> kinds{"png", "glb", "plan"};    // what is made
  std::vector<std::string> maps{"global", "local"};        // of what
};

// Values for keys of [map] that go together: map_preset.hpp.
enum class MapPreset { usual, fine };

// Where the robots of a team with a key meet when nothing is said of the network.
inline constexpr const char* kTeamGroup = "239.77.1.1:4600";

// Everything that a daemon can be told, with its defaults; files and the command line fill it.
struct Config {
  std::string id;                               // 1..16 characters of A-Z a-z 0-9 _ . -
  std::string camera = "auto";                  // address, see --help
  std::string out;                              // folder of what is written
  std::string listen;                           // ADDR:PORT; empty: 0.0.0.0, any port, when not alone
  std::vector<std::string> peers;               // ADDR:PORT
  std::string group;                            // multicast ADDR:PORT where robots meet; empty: none
  std::uint64_t bytes_per_second = 16'000'000;  // of what is sent at most, over all neighbours
  std::uint64_t link_bytes_per_second = 0;      // budget of each link, both ways; 0: none
  std::uint64_t link_mb_per_day = 0;            // the same by the day, in millions of bytes
  std::size_t store_budget_bytes = 256u << 20;  // records held, everybody's
  bool keep_log = true;                         // in OUT/log, unless the robot ends with its recording (once)
  bool once = false;                            // finish when the stream is over and the team agrees
  bool quick_stop = false;                      // a signal ends it within two seconds, without pictures
  Speed speed;
  double linger_s = 3;                // how long a finished robot still answers after all agree (once)
  double merge_while_mapping_s = 10;  // at most so often pairs are looked at while robots map; 0: only at the end
  double new_chain_after_s = 5;       // a camera that is lost for so long goes on in a map of its own; 0: never
  int chain_keyframes = 16000;        // after so many the robot goes on in a map of its own, which the team joins
  double map_interval_s = 0.5;        // at most so often the global map gets what is new while robots map
  double lost_after_s = 60;           // a robot that was silent for so long is not waited for
  double peer_wait_s = 20;            // how long a finished robot waits for peers that it never heard (once)
  int matches_picture = 0;            // a picture of the feature matches every so many frames; 0: none
  MapPreset preset = MapPreset::usual;
  mapping::LocalMapperConfig mapper;
  std::size_t global_budget_bytes = 128u << 20;
  std::size_t places_budget_bytes = 32u << 20;  // for the index of own keyframes
  mapping::SurveyConfig plan;                   // the floor plan
  bool refresh_plan = true;                     // anew with each settled map that is kept
  mapping::FindPairs find_pairs = mapping::FindPairs::by_index;
  // Key (SECTION.NAME) -> where its value is from: FILE:LINE or the command line. What is not here has its default.
  std::map<std::string, std::string> origins;
  std::string control_socket;   // path; empty: where control::default_socket() says
  std::string control_tcp;      // ADDR:PORT of loopback, read-only; empty: none
  std::string control_metrics;  // ADDR:PORT of loopback, HTTP; empty: none
  RecordConfig record;
  SnapshotsConfig snapshots;
  std::string poses_socket;  // path of pose_streams; empty: none

  std::string team_key_file;  // path, or none; empty: where team_seal looks
  std::string key_log;        // path; empty: none

  bool alone() const { return listen.empty() && peers.empty() && group.empty(); }
};

// Reads a TOML file over what `config` holds. Unknown keys and values out of range are errors with file:line, one for
// each; such a key keeps the value that it had. The keys are in config_key.hpp.
std::vector<Error> read_config(const std::string& file, Config& config);

// Whether a daemon can work with this, as far as it can be told before anything is opened: the id's form, that there
// are a camera and a place to write, what a mapper accepts and what does not fit together, addresses that can be
// reached, budgets that this machine has. The error's place is where the wrong value is from, if that is not its
// default, else its key.
Status check_config(const Config& config);

// The same of the mapper and a camera that is open now. The error's place is the key or the camera's property.
Status check_camera(const Config& config, const hal::Intrinsics& camera);

// A valid id for a robot that was given none: the host's name, with '-' for what an id must not have, cut to 16.
std::string id_from_host(const std::string& host);
std::string host_name();

}  // namespace onemap::daemon
