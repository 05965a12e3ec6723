#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/latency.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

struct RobotReport {
  std::string name, camera;
  std::uint64_t frames = 0;   // that the camera delivered
  std::uint64_t tracked = 0;  // lines of trajectory.txt
  std::uint64_t keyframes = 0;
  bool in_global_map = false;
  std::uint64_t map_digest = 0;  // of the global map as this robot holds it
  Quantiles ms_per_frame;        // processor time of the work thread for a frame
  double peak_rss_mb = 0;        // of the process while it mapped and merged, before pictures are drawn
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  std::uint64_t blocks_refused = 0;              // of the local map, for want of room: parts of it are missing
  std::uint64_t plan_squares = 0;                // of the floor plan; 0: there is none
  std::uint64_t plan_votes_refused = 0;          // of its free space, for want of room
  std::map<std::string, std::uint64_t> refused;  // datagrams and records, by reason
  std::string failed;                            // in a fleet: how the robot ended; empty: well
};

// What joined the maps of two robots, or did not (the paper's figure 9; eq. 9 to 11).
struct Merge {
  std::string a, b;                        // robots; NAME.NUMBER: an earlier life
  std::string refused;                     // why; empty: joined
  std::uint32_t cloud_a = 0, cloud_b = 0;  // the best pair of clouds r, s, by the numbers of their keyframes
  std::uint32_t pairs = 0, inliers = 0;    // pairs of clouds that agree; matched features of all of them
  double ratio = 0, error_mm = 0;          // of the best pair inliers / features; rms residual of those that agree
  double distance_m = 0, turn_deg = 0;     // of the one robot's reference in the other's
};

// OUT/report.json: of a team, or of one robot (then with one entry).
struct Report {
  bool same_map = false;
  std::string reference;  // empty: there is no global map
  std::uint64_t merge_ms = 0;
  std::uint64_t global_points = 0;
  std::vector<RobotReport> robots;
  std::vector<Merge> merges = {};  // of a team: each pair that somebody verified
};

std::string to_json(const Report& report);
Result<Report> report_from_json(const std::string& text, const std::string& place);
Result<Report> read_report(const std::string& file);

// A digest as people and files see it: 16 hexadecimal digits.
std::string digest_text(std::uint64_t digest);

// One table for people: robot, frames, tracked, keyframes, ms per frame, in the map, digest; below it a line for each
// thing that went wrong: robots that failed, blocks and records that were refused.
std::string to_table(const Report& report);

// The merges as a table for people, below it a line for each pair that was refused (the first ten), none wider than 100
// columns; no merges: nothing.
std::string to_table(const std::vector<Merge>& merges);

}  // namespace onemap::daemon
