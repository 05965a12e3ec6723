#include "daemon/publisher.hpp"

#include <utility>

#include "daemon/clock.hpp"
#include "mapping/local/local_mapper.hpp"

namespace onemap::daemon {

using mapping::Lane;
using mapping::RecordKind;

namespace {
// One record. It waits for the radio, which is watched more closely: of the two it is the radio that is named.
constexpr auto kPublisherStuckAfter = std::chrono::seconds(30);
}  // namespace

Publisher::Publisher(const mapping::LocalMapperConfig& config, WhenFull when_full, Outbox outbox, Failures& failures)
    : when_full_(when_full),
      outbox_(std::move(outbox)),
      failures_(failures),
      heartbeat_("publisher", kPublisherStuckAfter) {
  for (Sealed& slot : slots_) {
    mapping::LocalMapper::reserve_record(slot.keyframe, config);
    free_.push(&slot);
  }
}

Publisher::~Publisher() {
  filled_.close();
  join();
}

void Publisher::start() {
  // However the thread ends, the frame thread must not wait for a slot that will not come.
  thread_.start(
      "publisher", failures_, [this] { run(); },
      [this] {
        free_.close();
        filled_.close();
      });
}

Publisher::Sealed* Publisher::slot() {
  return when_full_ == WhenFull::wait ? awaited_slot() : free_.try_pop().value_or(nullptr);
}

Publisher::Sealed* Publisher::awaited_slot() { return free_.pop().value_or(nullptr); }

void Publisher::give_back(Sealed* slot) { free_.push(slot); }

void Publisher::publish(Sealed* slot) { filled_.push(slot); }

void Publisher::finish(std::uint32_t frames) {
  frames_ = frames;
  finished_ = true;
  filled_.close();
}

void Publisher::join() { thread_.join(); }

void Publisher::run() {
  while (const auto slot = filled_.pop()) {
    heartbeat_.beat(now());
    const Duration before = thread_cpu_time();
    encode_and_send(**slot);
    times_.add(thread_cpu_time() - before);
    heartbeat_.rest();
    free_.push(*slot);
  }
  if (finished_) outbox_.finish(frames_);
}

void Publisher::encode_and_send(const Sealed& sealed) {
  switch (sealed.what) {
    case Sealed::What::keyframe:
      return outbox_.publish({Lane::features, RecordKind::keyframe, encode(sealed.keyframe), 0});
    case Sealed::What::poses:
      return outbox_.publish({Lane::poses, RecordKind::trajectory, encode(sealed.poses),
                              static_cast<std::uint32_t>(sealed.poses.poses.size())});
    case Sealed::What::submap:
      return outbox_.publish({Lane::voxels, RecordKind::submap, encode(sealed.submap), 0});
    case Sealed::What::chain_end:
      return outbox_.next_chain(sealed.frames);
  }
}

}  // namespace onemap::daemon
