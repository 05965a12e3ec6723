#include <sys/un.h>

#include "comms/udp/udp_port.hpp"
#include "daemon/addresses.hpp"
#include "daemon/cameras.hpp"
#include "daemon/config_key_kinds.hpp"
#include "daemon/control/listener.hpp"
#include "daemon/map_preset.hpp"
#include "hal/base/ids.hpp"

namespace onemap::daemon {

using namespace key;

namespace {

using Limits = mapping::LocalMapperLimits;

Status any(const std::string&) { return success(); }

Status check_id(const std::string& id) {
  if (RobotId::valid_name(id)) return success();
  return Error{"", "'" + id + "' is not 1 to 16 characters of A-Z a-z 0-9 _ . -, the first no '.'"};
}

// What is no address because of its first word: the nearest that would begin one.
std::string near_camera(const std::string& address) {
  const std::size_t colon = address.find(':');
  std::vector<std::string_view> words;
  for (const hal::Backend& backend : camera_backends()) words.push_back(backend.name);
  const std::string word = address.substr(0, colon);
  if (std::ranges::find(words, word) != words.end()) return "";
  if (colon == std::string::npos) words.push_back("auto");
  return near_word(word, words);
}

Status check_camera_address(const std::string& address) {
  const Status status = hal::check_address(camera_backends(), address);
  return status ? success() : Error{"", status.error().text() + near_camera(address)};
}

constexpr std::size_t kSocketPath = sizeof sockaddr_un::sun_path - 1;
constexpr std::size_t kPosesPath = kSocketPath - std::string_view(".odom").size();

template <std::size_t most>
Status check_length(const std::string& path) {
  if (path.size() <= most) return success();
  return Error{"", fmt::format("a path of {} bytes, and a socket's may have {} here", path.size(), most)};
}

Status set_speed(const ConfigValue& value, Config& config) {
  const auto* word = std::get_if<std::string>(&value);
  const bool is_number = std::holds_alternative<std::int64_t>(value) || std::holds_alternative<double>(value);
  const auto speed = parse_speed(word ? *word : is_number ? toml_text(value) : "");
  if (!speed)
    return Error{"", speed.error().reason + (word ? near_word(*word, std::array<std::string_view, 1>{"max"}) : "")};
  config.speed = *speed;
  return success();
}

ConfigValue get_speed(const Config& config) {
  if (config.speed.max) return "max";
  return config.speed.factor;
}

constexpr Range<double> kSeconds{0, 1e6};
constexpr Range<std::size_t> kBudget = Limits::budget_bytes;
constexpr Range<double> kPlanCell_m{0.02, 0.5};
constexpr Range<std::size_t> kPlacesBudget{std::size_t{4} << 20, std::size_t{4} << 30};
constexpr Range<float> kTruncation{2 * Limits::voxel_m.least, Limits::truncation_voxels.most* Limits::voxel_m.most};
constexpr Range<std::size_t> kDisk{0, std::size_t{16} << 40};

void add_robot(std::vector<ConfigKey>& keys) {
  keys.push_back(text({"robot", "id", "name of this robot, unique in the team; empty: made of the host's name"},
                      "1 to 16 characters of A-Z a-z 0-9 _ . -, the first no '.'", &Config::id, check_id));
  keys.push_back(text({"robot", "camera", "address of the camera; auto: the first that can be used of this machine's"},
                      "auto, or BACKEND:PLACE, see onemapd --help", &Config::camera, check_camera_address));
  keys.push_back(text({"robot", "out",
                       "folder to write to; made when missing; empty: the service's $STATE_DIRECTORY, or a user's "
                       "state folder (~/.local/state/onemap)"},
                      "a path", &Config::out, any));
}

void add_network(std::vector<ConfigKey>& keys) {
  keys.push_back(text({"network", "listen", "UDP address to listen at; port 0: any; empty: 0.0.0.0:0"},
                      "ADDR:PORT, such as 0.0.0.0:4600 or [::]:4600", &Config::listen, check_listen));
  keys.push_back(
      list({"network", "peers", "neighbours to greet; none here, no listen and no group: the robot is alone"},
           "ADDR:PORT", "such as [\"10.0.0.2:4600\"]", &Config::peers, check_peer));
  keys.push_back(text(
      {"network", "group",
       fmt::format("IPv4 multicast group where robots of one network find each other; empty: none, but {} with a "
                   "team key, no listen, no peers and no run.once",
                   kTeamGroup)},
      fmt::format("ADDR:PORT from 224.0.0.0 to 239.255.255.255, such as {}", kTeamGroup), &Config::group, check_group));
  keys.push_back(number<std::uint64_t>(
      {"network", "bytes_per_second", "bytes a second sent at most, to all neighbours"}, {10'000, 1'000'000'000},
      [](auto& c) -> auto& { return c.bytes_per_second; }));
  keys.push_back(number<std::uint64_t>(
      {"network", "link_bytes_per_second",
       "bytes a second on the link to each neighbour, both ways together; beyond it only control and poses go; 0: any"},
      {0, 1'000'000'000}, [](auto& c) -> auto& { return c.link_bytes_per_second; }));
  keys.push_back(number<std::uint64_t>(
      {"network", "link_mb_per_day", "the same for a day, in MB, counted from the start of the daemon; 0: any"},
      {0, 100'000'000}, [](auto& c) -> auto& { return c.link_mb_per_day; }));
  keys.push_back(megabytes(
      {"network", "store_budget_mb", "MB for the records of all robots; full: refused and counted"}, kBudget,
      [](auto& c) -> auto& { return c.store_budget_bytes; }));
}

void add_team(std::vector<ConfigKey>& keys) {
  keys.push_back(
      text({"team", "key_file",
            "file with the team's key, mode 0600; empty: /etc/onemap/team.key, else OUT/team.key, if there is "
            "one; none: no key, and this machine's robots only"},
           "a path, or none", &Config::team_key_file, any));
  keys.push_back(
      text({"team", "key_log",
            "file to which the keys of sessions are written, to look into traffic with Wireshark; empty: none"},
           "a path", &Config::key_log, any));
}

void add_store(std::vector<ConfigKey>& keys) {
  keys.push_back(yes_or_no(
      {"store", "keep",
       "keep all records in OUT/log, so that a robot that starts again goes on in its team's map; not with run.once"},
      [](auto& c) -> auto& { return c.keep_log; }));
}

void add_run(std::vector<ConfigKey>& keys) {
  keys.push_back(yes_or_no(
      {"run", "once", "finish when the camera's stream is over and the team agrees"},
      [](auto& c) -> auto& { return c.once; }));
  keys.push_back(live(yes_or_no(
      {"run", "quick_stop",
       "asked to stop, end within two seconds: trajectories and the map, but no pictures, models and plan"},
      [](auto& c) -> auto& { return c.quick_stop; })));
  keys.push_back({"run", "speed", "pace of a recording: a factor, or \"max\": every frame, as fast as it goes",
                  "0.01 to 1000, or \"max\"", set_speed, get_speed});
  keys.push_back(live(number(
      {"run", "linger_s", "once: seconds to keep answering neighbours after all agree"}, kSeconds,
      [](auto& c) -> auto& { return c.linger_s; })));
  keys.push_back(number<double>(
      {"run", "lost_after_s", "seconds of silence after which a robot is not waited for"}, {1, kSeconds.most},
      [](auto& c) -> auto& { return c.lost_after_s; }));
  keys.push_back(live(number(
      {"run", "peer_wait_s", "once: seconds to wait for peers that were never heard"}, kSeconds,
      [](auto& c) -> auto& { return c.peer_wait_s; })));
  keys.push_back(number(
      {"run", "merge_while_mapping_s",
       "seconds between looks for links while robots map; 0: only at the end, and no map before"},
      kSeconds, [](auto& c) -> auto& { return c.merge_while_mapping_s; }));
  keys.push_back(number(
      {"run", "new_chain_after_s",
       "seconds after which a camera that sees something and is lost goes on in a map of its own; 0: never"},
      kSeconds, [](auto& c) -> auto& { return c.new_chain_after_s; }));
  keys.push_back(number<int>(
      {"run", "chain_keyframes",
       "keyframes after which the robot goes on in a new map of its own, which the team joins to the earlier one"},
      {100, 16000}, [](auto& c) -> auto& { return c.chain_keyframes; }));
  keys.push_back(number<double>(
      {"run", "map_interval_s", "seconds between two states of the global map while robots map"}, {0.1, kSeconds.most},
      [](auto& c) -> auto& { return c.map_interval_s; }));
  keys.push_back(either<mapping::FindPairs>(
      {"run", "find_pairs",
       "how keyframes of two robots that may show one place are found: by an index, or by matching all pairs"},
      {"index", mapping::FindPairs::by_index}, {"all-pairs", mapping::FindPairs::all_pairs},
      [](auto& c) -> auto& { return c.find_pairs; }));
  keys.push_back(number<int>(
      {"run", "matches_picture", "write a picture of the feature matches every so many frames; 0: none"},
      {0, 1'000'000}, [](auto& c) -> auto& { return c.matches_picture; }));
}

void add_tracking(std::vector<ConfigKey>& keys) {
  keys.push_back(either<mapping::DescriptorKind>(
      {"tracking", "features", "kind of the local features"}, {"surf", mapping::DescriptorKind::surf},
      {"orb", mapping::DescriptorKind::orb}, [](auto& c) -> auto& { return c.mapper.features; }));
  keys.push_back(number(
      {"tracking", "max_features", "features of a frame at most"}, Limits::max_features,
      [](auto& c) -> auto& { return c.mapper.max_features; }));
  keys.push_back(number(
      {"tracking", "max_keyframes", "keyframes kept; full: the most redundant old one makes room"},
      Limits::max_keyframes, [](auto& c) -> auto& { return c.mapper.max_keyframes; }));
  keys.push_back(number(
      {"tracking", "keyframe_translation_m", "metres from the nearest keyframe that make a new one"},
      Limits::keyframe_translation_m, [](auto& c) -> auto& { return c.mapper.keyframe_translation_m; }));
  keys.push_back(number(
      {"tracking", "keyframe_rotation_deg", "degrees from the nearest keyframe that make a new one"},
      Limits::keyframe_rotation_deg, [](auto& c) -> auto& { return c.mapper.keyframe_rotation_deg; }));
  keys.push_back(number(
      {"tracking", "min_motion_m", "metres of motion below which a frame is not fused into the map"},
      Limits::min_motion_m, [](auto& c) -> auto& { return c.mapper.min_motion_m; }));
  keys.push_back(number(
      {"tracking", "min_motion_deg", "degrees of motion below which a frame is not fused into the map"},
      Limits::min_motion_deg, [](auto& c) -> auto& { return c.mapper.min_motion_deg; }));
  keys.push_back(number<std::uint64_t>(
      {"tracking", "seed", "of the random choices: the same seed gives the same bytes"}, {0, INT64_MAX},
      [](auto& c) -> auto& { return c.mapper.seed; }));
}

void add_map(std::vector<ConfigKey>& keys) {
  keys.push_back(either<MapPreset>(
      {"map", "preset",
       fmt::format("fine, for models to be shown: those of these keys that have their default are {}; five times the "
                   "blocks and bytes, and two and a half times the fusion",
                   fine_values())},
      {"usual", MapPreset::usual}, {"fine", MapPreset::fine}, [](auto& c) -> auto& { return c.preset; }));
  keys.push_back(number(
      {"map", "voxel_m", "side of a voxel in metres"}, Limits::voxel_m,
      [](auto& c) -> auto& { return c.mapper.map.voxel_m; }));
  keys.push_back(number(
      {"map", "truncation_m",
       fmt::format("metres around a surface that are kept, {} to {} voxels", Limits::truncation_voxels.least,
                   Limits::truncation_voxels.most)},
      kTruncation, [](auto& c) -> auto& { return c.mapper.map.truncation_m; }));
  keys.push_back(number(
      {"map", "max_depth_m", "metres beyond which depth is not fused"}, Limits::max_depth_m,
      [](auto& c) -> auto& { return c.mapper.map.max_depth_m; }));
  keys.push_back(megabytes(
      {"map", "budget_mb", "MB for the own map; full: new blocks are refused and counted"}, kBudget,
      [](auto& c) -> auto& { return c.mapper.map.budget_bytes; }));
  keys.push_back(megabytes(
      {"map", "places_budget_mb",
       "MB for the index of own keyframes; full: every second one leaves, then every second of the rest, and so on"},
      kPlacesBudget, [](auto& c) -> auto& { return c.places_budget_bytes; }));
  keys.push_back(megabytes(
      {"map", "global_budget_mb", "MB for the team's map; full: blocks are refused and counted"}, kBudget,
      [](auto& c) -> auto& { return c.global_budget_bytes; }));
  keys.push_back(number(
      {"map", "plan_cell_m", "side of a square of the floor plan (map.pgm) in metres"}, kPlanCell_m,
      [](auto& c) -> auto& { return c.plan.space.cell_m; }));
  keys.push_back(yes_or_no(
      {"map", "refresh_plan",
       "write map.pgm and map.yaml in OUT anew while the robot works: when the settled map has changed, at most every "
       "30 seconds; else at the end and with a snapshot that holds the plan; not with run.once"},
      [](auto& c) -> auto& { return c.refresh_plan; }));
  keys.push_back(megabytes(
      {"map", "plan_budget_mb", "MB for the free space under the floor plan; full: votes are refused and counted"},
      kBudget, [](auto& c) -> auto& { return c.plan.space.budget_bytes; }));
}

void add_control(std::vector<ConfigKey>& keys) {
  keys.push_back(text({"control", "socket",
                       "Unix socket for onemapctl; empty: $RUNTIME_DIRECTORY/control.sock, else "
                       "$XDG_RUNTIME_DIR/onemap/ID.sock, else OUT/control.sock"},
                      fmt::format("a path of at most {} bytes", kSocketPath), &Config::control_socket,
                      check_length<kSocketPath>));
  keys.push_back(text({"control", "tcp", "TCP port of loopback that answers the same and changes nothing; empty: none"},
                      "ADDR:PORT of loopback, such as 127.0.0.1:4680", &Config::control_tcp, check_loopback));
  keys.push_back(text({"control", "metrics", "TCP port of loopback for Prometheus (GET /metrics); empty: none"},
                      "ADDR:PORT of loopback, such as 127.0.0.1:9464", &Config::control_metrics, check_loopback));
}

void add_record(std::vector<ConfigKey>& keys) {
  keys.push_back(yes_or_no(
      {"record", "start", "record the camera from the start on, to OUT/recordings"},
      [](auto& c) -> auto& { return c.record.start; }));
  keys.push_back(some_of(
      {"record", "formats", "tum: what replay:DIR plays; mcap: recording.mcap to look at, for Foxglove"},
      {"tum", "mcap"}, [](auto& c) -> auto& { return c.record.formats; }));
  keys.push_back(megabytes(
      {"record", "limit_mb", "MB of one recording at most; then it ends, and the daemon goes on"},
      {std::size_t{1} << 20, kDisk.most}, [](auto& c) -> auto& { return c.record.limit_bytes; }));
  keys.push_back(megabytes(
      {"record", "least_free_mb", "MB of the disk that a recording leaves free; fewer: it ends"}, kDisk,
      [](auto& c) -> auto& { return c.record.least_free_bytes; }));
}

void add_snapshots(std::vector<ConfigKey>& keys) {
  keys.push_back(live(number(
      {"snapshots", "every_s", "seconds from one snapshot of the maps to the next, in OUT/snapshots; 0: not by time"},
      kSeconds, [](auto& c) -> auto& { return c.snapshots.every_s; })));
  keys.push_back(live(yes_or_no(
      {"snapshots", "on_change", "a snapshot when the map has changed, at most every 10 seconds"},
      [](auto& c) -> auto& { return c.snapshots.on_change; })));
  keys.push_back(number<std::size_t>(
      {"snapshots", "keep", "snapshots kept; the oldest go"}, {1, 1'000'000},
      [](auto& c) -> auto& { return c.snapshots.keep; }));
  keys.push_back(megabytes(
      {"snapshots", "disk_limit_mb", "MB of all snapshots together; the oldest go"}, {std::size_t{1} << 20, kDisk.most},
      [](auto& c) -> auto& { return c.snapshots.disk_limit_bytes; }));
  keys.push_back(live(some_of(
      {"snapshots", "views", "where the pictures of a snapshot look from"}, {"fit", "top", "follow", "plan", "front"},
      [](auto& c) -> auto& { return c.snapshots.views; })));
  keys.push_back(live(some_of(
      {"snapshots", "kinds", "what a snapshot holds; plan: map.pgm and map.yaml, in OUT, too"}, {"png", "glb", "plan"},
      [](auto& c) -> auto& { return c.snapshots.kinds; })));
  keys.push_back(live(some_of(
      {"snapshots", "maps", "of which maps: the team's, and this robot's own"}, {"global", "local"},
      [](auto& c) -> auto& { return c.snapshots.maps; })));
}

void add_poses(std::vector<ConfigKey>& keys) {
  keys.push_back(text({"poses", "socket",
                       "Unix sockets for other programs, a line `time tx ty tz qx qy qz qw` a frame: SOCKET.odom never "
                       "jumps, SOCKET.map may; empty: none"},
                      fmt::format("a path of at most {} bytes", kPosesPath), &Config::poses_socket,
                      check_length<kPosesPath>));
}

constexpr ConfigSection kSections[] = {
    {"robot", "who this robot is, what it sees with, where it writes"},
    {"network", "whom it talks to over UDP"},
    {"team", "the key that makes robots a team"},
    {"store", "what it keeps on its disk"},
    {"run", "how long it works and whom it waits for"},
    {"tracking", "how it finds its way"},
    {"map", "what it keeps of what it saw"},
    {"control", "how people and programs of this machine reach it"},
    {"record", "recordings of the camera, as replay:DIR plays them"},
    {"snapshots", "pictures, models and floor plans of the maps while it works"},
    {"poses", "where the camera is, for other programs"},
};

}  // namespace

std::span<const ConfigSection> config_sections() { return kSections; }

std::span<const ConfigKey> config_keys() {
  static const std::vector<ConfigKey> table = [] {
    std::vector<ConfigKey> keys;
    for (const auto add : {add_robot, add_network, add_team, add_store, add_run, add_tracking, add_map, add_control,
                           add_record, add_snapshots, add_poses})
      add(keys);
    return keys;
  }();
  return table;
}

const ConfigKey* find_key(std::string_view section, std::string_view name) {
  for (const ConfigKey& key : config_keys())
    if (key.section == section && key.name == name) return &key;
  return nullptr;
}

}  // namespace onemap::daemon
