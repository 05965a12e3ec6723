#include "daemon/snapshots.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <future>

#include "daemon/clock.hpp"
#include "daemon/team.hpp"

namespace onemap::daemon {

namespace {

constexpr int kNiceness = 10;
constexpr auto kLongestDrawing = std::chrono::seconds(120);
constexpr auto kRest = std::chrono::seconds(10);        // from one snapshot of a changed map to the next
constexpr auto kMapPatience = std::chrono::seconds(5);  // for the global map that is being built
constexpr auto kLookForCopy = std::chrono::milliseconds(50);

bool has(const std::vector<std::string>& words, const char* word) {
  return std::ranges::find(words, word) != words.end();
}

}  // namespace

SnapshotWish default_wish(const SnapshotsConfig& config) { return {config.views, config.kinds, config.maps}; }

PictureLimits Snapshots::snapshot_limits() {
  PictureLimits limits;
  limits.time = kLongestDrawing;
  return limits;  // the thread's niceness is its children's, too
}

Snapshots::Snapshots(const Config& config, Take take, Failures& failures, Log& log, PictureLimits limits)
    : config_(config),
      take_(std::move(take)),
      failures_(failures),
      log_(log),
      limits_(std::move(limits)),
      folder_(config.out + "/snapshots", config.snapshots.keep, config.snapshots.disk_limit_bytes) {
  limits_.cancelled = [this] { return stopping_.load(); };
}

Snapshots::~Snapshots() { stop(); }

void Snapshots::start() {
  thread_.start("snapshots", failures_, [this] { run(); });
}

void Snapshots::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::uint64_t Snapshots::request(SnapshotWish wish) {
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = ++requests_;
    if (waiting_) ++view_.coalesced;
    waiting_ = Job{number, std::move(wish)};
  }
  wake_.notify_one();
  return number;
}

void Snapshots::tick(Instant now, std::uint64_t map_digest) {
  const SnapshotsConfig& c = config_.snapshots;
  const auto every = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(c.every_s));
  const bool timed = every > Duration::zero();
  if (!due_) due_ = now + every;
  const bool due = timed && now >= *due_;
  const bool changed = c.on_change && map_digest != 0 && map_digest != drawn_digest_ &&
                       (drawn_digest_ == 0 || now - changed_at_ >= kRest);
  if (!due && !changed) return;
  if (due) due_ = now + every;
  changed_at_ = now;
  drawn_digest_ = map_digest;
  request(default_wish(c));
}

SnapshotsView Snapshots::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

std::optional<Snapshots::Job> Snapshots::next() {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return stopping_ || waiting_; });
  if (stopping_) return std::nullopt;
  view_.busy = true;
  return std::exchange(waiting_, std::nullopt);
}

void Snapshots::run() {
  // Of this thread alone, as Linux has it, and of the programs that it starts.
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
  while (const auto job = next()) {
    const Instant began = now();
    Result<Made> made = Error{};
    const auto done = guarded("snapshot", [&] {
      made = make(job->wish);
      return made ? success() : Status(made.error());
    });
    if (!done) {
      made = done.error();
      folder_.give_up();
    }
    note(*job, made, now() - began);
  }
}

Result<Snapshots::Made> Snapshots::make(const SnapshotWish& wish) {
  const auto copy = take_([this] { return stopping_.load(); });
  if (!copy) return Error{"snapshot", "left off"};
  auto folder = folder_.begin();
  if (!folder) return folder.error();
  const MapSource from{copy->log, copy->solution ? &*copy->solution : nullptr, copy->map ? &*copy->map : nullptr};
  if (auto filled = fill(*folder, from, wish); !filled) return filled.error();
  auto published = folder_.publish();
  if (!published) return published.error();
  return Made{*published, to_seconds(copy->took) * 1e3};
}

Status Snapshots::fill(const std::string& folder, const MapSource& from, const SnapshotWish& wish) {
  bool any = false;
  for (const MapPicture& picture : pictures(folder, from, wish)) {
    const auto drawn = draw(picture);
    if (!drawn) return drawn.error();
    any = true;
  }
  if (has(wish.kinds, "plan")) {
    const auto planned =
        write_plan(from, config_.plan, {folder + "/map", config_.out + "/map"}, [this] { return stopping_.load(); });
    if (!planned) return planned.error();
    any = any || *planned;
  }
  return any ? success() : Status(Error{"snapshot", "there is nothing to draw yet"});
}

std::vector<MapPicture> Snapshots::pictures(const std::string& folder, const MapSource& from,
                                            const SnapshotWish& wish) const {
  std::vector<MapPicture> pictures;
  MapPicture picture{folder, {}, has(wish.kinds, "png"), has(wish.kinds, "glb"), false, wish.views};
  if (!picture.png && !picture.glb) return pictures;
  const auto add = [&](const char* name, std::vector<std::uint8_t> map) {
    picture.stem = folder + "/" + name;
    picture.map = std::move(map);
    pictures.push_back(picture);
  };
  const std::string local = "local map of " + config_.id;
  if (config_.alone() && from.solution != nullptr) return add("local", save_global(from, local)), pictures;
  if (has(wish.maps, "global") && from.solution != nullptr) add("global", save_global(from, "global map"));
  if (!has(wish.maps, "local")) return pictures;
  if (auto map = save_local(from, config_, local, [this] { return stopping_.load(); })) add("local", std::move(*map));
  return pictures;
}

Result<bool> Snapshots::draw(const MapPicture& picture) {
  const PictureResult result = write_pictures({picture}, limits_).front();
  if (result.killed && !stopping_) {
    const std::lock_guard lock(mutex_);
    ++view_.killed;
  }
  if (!result.status) return result.status.error();
  return true;
}

void Snapshots::note(const Job& job, const Result<Made>& made, Duration took) {
  if (made)
    log_.limited("snapshot", "snapshot in {}: {:.1f} s, for {:.0f} ms of which the team's work stood still",
                 made->folder, to_seconds(took), made->copy_ms);
  else if (!stopping_)
    log_.limited("snapshot failed",
                 "no snapshot: {}; it is tried again when the next is due, or by `onemapctl snapshot`",
                 made.error().text());
  const std::lock_guard lock(mutex_);
  ++(made ? view_.made : view_.failed);
  view_.busy = false;
  view_.finished = job.number;
  view_.folder = made ? made->folder : "";
  view_.error = made ? "" : made.error().text();
  view_.took_s = to_seconds(took);
  view_.copy_ms = made ? made->copy_ms : 0;
  view_.removed = folder_.removed();
}

Snapshots::Take take_from(Team& team) {
  return [&team](const std::function<bool()>& stop) -> std::optional<MapCopy> {
    // Shared with the team's thread, which may come to it when nobody waits any more.
    auto promised = std::make_shared<std::promise<MapCopy>>();
    auto copy = promised->get_future();
    team.ask([promised, patience = now() + kMapPatience](const mapping::TeamMap& map) {
      const Instant began = now();
      if (map.map() == nullptr && began < patience) return false;  // on its way from one map to the next
      MapCopy taken = copy_map(map);
      taken.took = now() - began;
      promised->set_value(std::move(taken));
      return true;
    });
    while (copy.wait_for(kLookForCopy) != std::future_status::ready)
      if (stop()) return std::nullopt;
    return copy.get();
  };
}

}  // namespace onemap::daemon
