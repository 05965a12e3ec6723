#include "daemon/control/output_actions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "daemon/config_key.hpp"
#include "daemon/map_drawing.hpp"
#include "daemon/report.hpp"
#include "daemon/saved_map.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

using control::Json;

namespace {
// A list of words in a request, judged as the configuration's key of that name judges it.
Status take_words(const Json& request, const char* key, std::vector<std::string>& into) {
  const auto given = request.find(key);
  if (given == request.end()) return success();
  std::vector<std::string> words;
  if (given->is_string()) words.push_back(given->get<std::string>());
  if (given->is_array())
    for (const Json& word : *given) words.push_back(word.is_string() ? word.get<std::string>() : "");
  Config judge;
  if (auto set = find_key("snapshots", key)->set(words, judge); !set)
    return Error{"", fmt::format("{}: {}", key, set.error().reason)};
  into = std::move(words);
  return success();
}

Result<SnapshotWish> wish_of(const Json& request, const Config& config) {
  SnapshotWish wish = default_wish(config.snapshots);
  for (const auto& [key, into] : {std::pair{"maps", &wish.maps}, {"views", &wish.views}, {"kinds", &wish.kinds}})
    if (auto taken = take_words(request, key, *into); !taken) return taken.error();
  return wish;
}

Json recording_json(const RecorderView& view) {
  return {{"recording", view.recording}, {"folder", printable(view.folder)}, {"frames", view.frames},
          {"bytes", view.bytes},         {"frames_dropped", view.dropped},   {"ended", printable(view.ended)}};
}

constexpr std::size_t kMostMapBytes = std::size_t{512} << 20;

// What a saved map holds.
Result<Json> saved_json(const std::string& file) {
  std::vector<std::uint8_t> bytes;
  if (auto read = read_regular_file(file, bytes, kMostMapBytes); !read) return read.error();
  const auto scene = load_map(file, bytes);
  if (!scene) return scene.error();
  Json robots = Json::array();
  for (const auto& path : scene->robots) robots.push_back(printable(path.name));
  return Json{{"path", printable(file)},
              {"title", printable(scene->title)},
              {"robots", std::move(robots)},
              {"vertices", scene->mesh.vertices.size()}};
}
}  // namespace

Result<std::string> path_below(const std::string& out, const Json& request, const std::string& otherwise) {
  const auto name = text_in(request, "path", otherwise);
  if (!name) return name.error();
  const std::filesystem::path path(*name);
  const bool climbs = std::ranges::find(path, "..") != path.end();
  if (name->empty() || path.is_absolute() || climbs || printable(*name) != *name)
    return Error{"", "path: expected the name of something below OUT (" + printable(out) + "), without '..'"};
  return out + "/" + *name;
}

OutputActions::OutputActions(const Config& config, Snapshots& snapshots, Recorder& recorder, Snapshots::Take take,
                             OwnRecords records)
    : config_(config),
      snapshots_(snapshots),
      recorder_(recorder),
      take_(std::move(take)),
      records_(std::move(records)) {}

void OutputActions::add_to(ControlActions& actions) {
  actions.snapshot = [this](const Json& request, const Later& later) { snapshot(request, later); };
  actions.record = [this](const Json& request, const Later& later) { record(request, later); };
  actions.save = [this](const Json& request, const Later& later) { save(request, later); };
  actions.load = [this](const Json& request, const Later& later) { load(request, later); };
}

void OutputActions::snapshot(const Json& request, const Later& later) {
  auto wish = wish_of(request, config_);
  if (!wish) return later(wish.error());
  waiting_.push_back({snapshots_.request(std::move(*wish)), later});
}

void OutputActions::tick() {
  if (waiting_.empty()) return;
  const SnapshotsView view = snapshots_.view();
  for (; !waiting_.empty() && waiting_.front().number <= view.finished; waiting_.pop_front()) {
    const Waiting& done = waiting_.front();
    if (done.number == view.finished && !view.error.empty())
      done.later(Error{"", view.error});
    else
      done.later(Json{{"folder", printable(view.folder)}, {"took_s", view.took_s}});
  }
}

// Where the daemon may be slow it is the thread of jobs that waits.
void OutputActions::work(const Later& later, std::function<Result<Json>(const std::atomic<bool>&)> job) {
  const bool posted = jobs_.post([later, job = std::move(job)](const std::atomic<bool>& stopping) {
    Result<Json> result = Error{};
    try {
      result = job(stopping);
    } catch (...) {
      result = Error{"", what_of_current_exception()};
    }
    later(std::move(result));
  });
  if (!posted) later(Error{"", fmt::format("{} jobs wait already; try again", JobThread::kWaiting)});
}

void OutputActions::record(const Json& request, const Later& later) {
  const auto enable = flag_in(request, "enable", true);
  if (!enable) return later(enable.error());
  if (!*enable) return work(later, [this](const auto&) -> Result<Json> { return recording_json(recorder_.stop()); });
  std::string folder;
  if (request.contains("path")) {
    const auto path = path_below(config_.out, request, "");
    if (!path) return later(path.error());
    folder = *path;
  }
  work(later, [this, folder](const auto&) -> Result<Json> {
    const Status begun = recorder_.start(folder.empty() ? next_recording(config_.out) : folder);
    if (!begun) return begun.error();
    return recording_json(recorder_.view());
  });
}

// NAME.log: the records. Else the team's map where there is one, or this robot's own.
void OutputActions::save(const Json& request, const Later& later) {
  const auto path = path_below(config_.out, request, "saved.omap");
  if (!path) return later(path.error());
  if (path->ends_with(".log"))
    return work(later, [this, folder = *path](const auto& stop) { return save_records(records_, folder, stop); });
  work(later, [this, file = *path](const std::atomic<bool>& stopping) -> Result<Json> {
    const auto stop = [&] { return stopping.load(); };
    const auto copy = take_(stop);
    if (!copy) return Error{"", "the daemon is ending"};
    const MapSource from{copy->log, copy->solution ? &*copy->solution : nullptr, copy->map ? &*copy->map : nullptr};
    std::optional<std::vector<std::uint8_t>> bytes;
    if (from.map != nullptr)
      bytes = save_global(from, "global map");
    else
      bytes = save_local(from, config_, "local map of " + config_.id, stop);
    if (!bytes) return Error{"", "there is no map yet"};
    if (auto written = write_file(file, *bytes); !written) return written.error();
    return Json{{"path", printable(file)}, {"bytes", bytes->size()}, {"global", from.map != nullptr}};
  });
}

void OutputActions::load(const Json& request, const Later& later) {
  const auto path = path_below(config_.out, request, "");
  if (!path) return later(path.error());
  work(later, [this, file = *path](const auto& stopping) {
    std::error_code none;
    return std::filesystem::is_directory(file, none) ? load_records(records_, file, stopping) : saved_json(file);
  });
}

}  // namespace onemap::daemon
