#include "daemon/map_keeper.hpp"

#include "daemon/clock.hpp"

namespace onemap::daemon {

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
  map_.trying(now());
  const Status kept = guarded("settled map", [this] {
    const auto saved = take_([this] { return stopping_.load(); });
    return saved ? map_.keep(saved->digest, saved->bytes, now()) : success();
  });
  if (!kept) log_.limited("settled map", "the settled map is not kept: {}", kept.error().text());
}

}  // namespace onemap::daemon
