#include "daemon/team.hpp"

#include "daemon/clock.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kLook = std::chrono::milliseconds(250);
constexpr auto kLongestEnd = std::chrono::milliseconds(1500);  // for the map that was being built when asked to stop
}  // namespace

Team::Team(const RobotId& self, std::uint64_t, const TeamMapConfig& config, Publish publish, Failures& failures,
           Log& log)
    : failures_(failures), map_(self, config, std::move(publish), log) {}

Team::~Team() { stop(); }

void Team::start() {
  thread_.start("team", failures_, [this] { run(); });
}

void Team::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Team::apply(std::shared_ptr<const Record> record) {
  {
    const std::lock_guard lock(mutex_);
    inbox_.push_back(std::move(record));
    view_.settled = false;  // until the thread has looked at it
  }
  wake_.notify_one();
}

void Team::begin_life(std::uint64_t) {}
void Team::presence(const std::map<RobotId, Instant>&, const std::set<RobotId>&) {}

TeamView Team::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

std::vector<std::shared_ptr<const Record>> Team::wait_for_records() {
  std::unique_lock lock(mutex_);
  // Some work becomes due by time alone.
  wake_.wait_for(lock, kLook, [&] { return stopping_ || !inbox_.empty(); });
  return std::exchange(inbox_, {});
}

void Team::run() {
  bool busy = false;
  while (!stopping_) {
    std::vector<std::shared_ptr<const Record>> records;
    if (busy) {
      const std::lock_guard lock(mutex_);
      records = std::exchange(inbox_, {});
    } else {
      records = wait_for_records();
    }
    const Instant arrived = now();
    for (const auto& record : records) map_.apply(record, arrived);
    if (stopping_) break;
    busy = map_.step(arrived, [this] { return stopping_.load(); });
    map_.observe(now());
    const std::lock_guard lock(mutex_);
    view_ = map_.view();
    view_.settled = view_.settled && inbox_.empty();
  }
  const Instant end = now() + kLongestEnd;
  map_.finish_fusion([&] { return now() > end; });
  const std::lock_guard lock(mutex_);
  view_ = map_.view();
  view_.settled = view_.settled && inbox_.empty();
}

}  // namespace onemap::daemon
