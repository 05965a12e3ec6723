#pragma once
#include <cstdint>
#include <string>

#include "daemon/capture.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/link_tally.hpp"
#include "daemon/pipeline.hpp"
#include "daemon/radio.hpp"
#include "daemon/recorder.hpp"
#include "daemon/snapshots.hpp"
#include "daemon/status.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

struct CameraFacts {
  std::string address, description;
  bool live = false, away = false, ended = false;
  hal::Intrinsics intrinsics;
  std::string limits;  // why it does less than it could; empty: it does not
};

// What the daemon's surroundings look like from inside it.
struct PlaceFacts {
  std::string out, socket;
  std::uint64_t disk_free_bytes = 0;
  bool out_writable = false;
};

// Everything that this robot can say of itself, at one time: answers and metrics are functions of it.
struct RobotFacts {
  std::string id, version, listen;
  bool alone = true;
  std::uint64_t life = 0;
  Instant now{};
  double uptime_s = 0, rss_mb = 0, peak_rss_mb = 0;
  DaemonStatus status;
  CameraFacts camera;
  CaptureCounters capture;
  PipelineView pipeline;
  std::size_t local_blocks_most = 0, global_blocks_most = 0;  // that the budgets hold
  TeamView team;
  LinkTally links;
  RadioView radio;
  RecorderView recorder;
  SnapshotsView snapshots;
  ControlCounters control;
  std::size_t control_clients = 0;
  PlaceFacts place;
};

}  // namespace onemap::daemon
