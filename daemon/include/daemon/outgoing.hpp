#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "mapping/records/kind.hpp"

namespace onemap::daemon {

// A record of this robot on its way into its log.
struct OutgoingRecord {
  mapping::Lane lane = mapping::Lane::control;
  mapping::RecordKind kind = mapping::RecordKind::hello;
  std::vector<std::uint8_t> body;
  std::uint32_t poses = 0;  // in a trajectory record
  // Set: after so many frames this life ends, and the record, a Hello, is the first one of the next.
  std::optional<std::uint32_t> ends_life_of = {};
};

// What of this robot's own work is in its log. A log may refuse (its store is full), so this, and not what was handed
// to it, is what others may wait for.
struct Published {
  std::uint32_t keyframes = 0, submaps = 0, poses = 0;
  std::uint64_t refused = 0;  // records
  void forget(mapping::RecordKind kind) {
    keyframes -= kind == mapping::RecordKind::keyframe;
    submaps -= kind == mapping::RecordKind::submap;
  }
  void count(const OutgoingRecord& record) {
    keyframes += record.kind == mapping::RecordKind::keyframe;
    submaps += record.kind == mapping::RecordKind::submap;
    poses += record.poses;
  }
};

// Takes a record for the log; may be called from any thread and never waits for the network.
using Publish = std::function<void(OutgoingRecord)>;

// Where a robot's work goes; empty functions when it is alone.
struct Outbox {
  Publish publish;
  std::function<void(std::uint32_t frames)> finish;  // the camera's stream is over: nothing more comes
  // What follows is of another chain: nobody knows yet where the camera is beside what came before.
  std::function<void(std::uint32_t frames)> next_chain;
};

}  // namespace onemap::daemon
