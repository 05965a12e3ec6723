#include "daemon/map_keeper.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr int kKeepersNiceness = 10;
}

void MapKeeper::start() {
  thread_.start("map keeper", failures_, [this] { run(); });
}

void MapKeeper::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void MapKeeper::tick(std::uint64_t digest, bool settled, Instant now) {
  {
    const std::lock_guard lock(mutex_);
    if (wanted_ || busy_ || !map_.due(digest, settled, now)) return;
    wanted_ = true;
  }
  wake_.notify_all();
}

void MapKeeper::run() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kKeepersNiceness);  // of this thread alone, as Linux has it
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return wanted_ || stopping_; });
    if (stopping_) return;
    wanted_ = false;
    busy_ = true;
    lock.unlock();
    keep();
    lock.lock();
    busy_ = false;
  }
}

void MapKeeper::keep() {
  const std::function<bool()> stop = [this] { return stopping_.load(); };
  Then then;
  const Status kept = guarded("settled map", [&] {
    auto saved = take_(stop);
    if (!saved) return success();  // the team is on its way to another one: the next look asks again
    then = std::move(saved->then);
    return map_.keep(saved->digest, saved->bytes, now());
  });
  if (!kept) {
    map_.trying(now());
    log_.limited("settled map",
                 "the settled map is not kept: {}; the one before stays, and it is tried again soon: make room, or OUT "
                 "writable",
                 kept.error().text());
  }
  if (!then || stop()) return;
  if (const Status done = guarded("floor plan", [&] { return then(stop); }); !done)
    log_.limited(
        "floor plan",
        "map.pgm and map.yaml stay as they were: {}; make room, or OUT writable; map.refresh_plan = false does "
        "without",
        done.error().text());
}

}  // namespace onemap::daemon
