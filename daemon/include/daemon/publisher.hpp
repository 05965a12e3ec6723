#pragma once
#include <array>
#include <atomic>
#include <cstdint>

#include "daemon/config.hpp"
#include "daemon/heartbeat.hpp"
#include "daemon/latency.hpp"
#include "daemon/outgoing.hpp"
#include "daemon/worker.hpp"
#include "hal/base/bounded_queue.hpp"
#include "mapping/records/keyframe.hpp"
#include "mapping/records/submap.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::daemon {

// The publisher thread: encodes and compresses what the frame thread sealed, so that a frame never waits for that. A
// few slots go round between the two; their memory is taken once.
class Publisher {
 public:
  // One thing that the mapper sealed, and which of the members it is in.
  struct Sealed {
    enum class What : std::uint8_t { keyframe, poses, submap, chain_end } what = What::keyframe;
    mapping::KeyframeRecord keyframe;
    mapping::TrajectoryRecord poses;
    mapping::SubmapRecord submap;
    std::uint32_t frames = 0;  // of the chain that ends
  };
  // What a frame thread does that finds all slots on their way.
  enum class WhenFull : std::uint8_t {
    wait,   // for a slot: every record is published in the order of the frames (recordings at full speed)
    later,  // the mapper keeps what it sealed until there is a slot (a camera does not wait)
  };

  Publisher(const mapping::LocalMapperConfig& config, WhenFull when_full, Outbox outbox, Failures& failures);
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  void start();
  // A slot to be filled; nullptr: none is free (WhenFull::later), or the thread has ended.
  Sealed* slot();
  Sealed* awaited_slot();        // waits for one; nullptr: the thread has ended
  void give_back(Sealed* slot);  // there was nothing to fill it with
  void publish(Sealed* slot);
  // Nothing more comes: encodes what is on its way, then tells the outbox that the work is finished.
  void finish(std::uint32_t frames);
  void join();
  const LatencyHistogram& times() const { return times_; }  // processor time of a record; after join()
  const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  static constexpr std::size_t kSlots = 4;
  void run();
  void encode_and_send(const Sealed& sealed);

  const WhenFull when_full_;
  Outbox outbox_;
  Failures& failures_;
  std::array<Sealed, kSlots> slots_;
  BlockingQueue<Sealed*> free_{kSlots}, filled_{kSlots};
  std::atomic<std::uint32_t> frames_ = 0;
  std::atomic<bool> finished_ = false;
  LatencyHistogram times_;
  Heartbeat heartbeat_;
  Worker thread_;
};

}  // namespace onemap::daemon
