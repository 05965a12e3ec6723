#include "daemon/control/output_actions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "hal/base/file.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace fs = std::filesystem;

namespace {

// `words` becomes the one word that the request gives, if it gives one of these.
Status choose(const Json& request, std::string_view key, const std::vector<std::string>& known,
              std::vector<std::string>& words) {
  const auto given = text_in(request, key, "");
  if (!given) return given.error();
  if (given->empty()) return success();
  if (std::ranges::find(known, *given) == known.end())
    return Error{"", fmt::format("{}: '{}' is not one of {}", key, *given, fmt::join(known, ", "))};
  words = {*given};
  return success();
}

Result<SnapshotWish> wish_of(const Json& request, const Config& config) {
  SnapshotWish wish = default_wish(config.snapshots);
  if (auto chosen = choose(request, "map", {"global", "local"}, wish.maps); !chosen) return chosen.error();
  if (auto chosen = choose(request, "view", {"fit", "top", "follow", "plan", "front"}, wish.views); !chosen)
    return chosen.error();
  if (auto chosen = choose(request, "format", {"png", "glb", "plan"}, wish.kinds); !chosen) return chosen.error();
  return wish;
}

std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code))
    names.push_back(it->path().filename().string());
  std::ranges::sort(names);
  return names;
}

Result<Json> made(const SnapshotsView& view, const std::string& path) {
  if (!view.error.empty()) return Error{"", view.error};
  const std::vector<std::string> files = files_of(view.folder);
  Json answer{{"folder", printable(view.folder)}, {"files", Json::array()}, {"took_s", view.took_s}};
  for (const std::string& file : files) answer["files"].push_back(printable(file));
  if (path.empty() || files.empty()) return answer;
  const auto bytes = read_file(view.folder + "/" + files.front());
  const Status copied = bytes ? write_file(path, *bytes) : Status(bytes.error());
  if (!copied) return Error{"", copied.error().text()};
  answer["path"] = printable(path);
  return answer;
}

Json json_of(const RecorderView& view) {
  Json answer{{"recording", view.recording},
              {"folder", printable(view.folder)},
              {"frames", view.frames},
              {"bytes", view.bytes},
              {"dropped", view.dropped}};
  if (!view.ended.empty()) answer["ended"] = printable(view.ended);
  return answer;
}

}  // namespace

ControlActions::Action snapshot_action(Snapshots& snapshots, const Config& config) {
  return [&snapshots, &config](const Json& request, const Later& later) {
    auto wish = wish_of(request, config);
    if (!wish) return later(wish.error());
    const auto path = text_in(request, "path", "");
    if (!path) return later(path.error());
    snapshots.request(std::move(*wish), [later, path = *path](const SnapshotsView& view) { later(made(view, path)); });
  };
}

ControlActions::Action record_action(Recorder& recorder, const Config& config) {
  return [&recorder, &config](const Json& request, const Later& later) {
    const auto enable = flag_in(request, "enable", true);
    if (!enable) return later(enable.error());
    if (!*enable) return recorder.stop_later([later](const RecorderView& view) { later(json_of(view)); });
    const auto path = text_in(request, "path", "");
    if (!path) return later(path.error());
    const bool relative = !path->starts_with('/');
    const std::string folder = path->empty() ? next_recording(config.out) : relative ? config.out + "/" + *path : *path;
    const auto begun = recorder.start(folder);
    later(begun ? Result<Json>(json_of(recorder.view())) : Result<Json>(Error{"", begun.error().text()}));
  };
}

}  // namespace onemap::daemon
