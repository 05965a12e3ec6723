#include "recording.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "hal/backends/replay.hpp"
#include "hal/base/file.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::replay {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostListBytes = 256u << 20;

bool present(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// The images of a frame-NNNNNN.color.png / frame-NNNNNN.depth.png folder by frame number.
struct NumberedImages {
  std::map<std::uint64_t, std::string> color, depth;
};

void add_numbered(const std::string& name, NumberedImages& images) {
  if (!name.starts_with("frame-")) return;
  const std::string_view rest = std::string_view(name).substr(6);
  const auto frame = parse_count(rest.substr(0, rest.find('.')));
  if (!frame || *frame > 1'000'000'000) return;
  const std::string_view kind = rest.substr(rest.find('.') + 1);
  // Folders are listed in any order; of two files for one frame the last by name is taken (.png before .jpg).
  const auto keep = [&, number = *frame](auto& kept) { kept[number] = std::max(kept[number], name); };
  if (kind == "color.png" || kind == "color.jpg") keep(images.color);
  if (kind == "depth.png") keep(images.depth);
}

Result<NumberedImages> list_numbered(const fs::path& folder) {
  NumberedImages images;
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code))
    add_numbered(it->path().filename().string(), images);
  if (code) return Error{folder.string(), "cannot be listed: " + code.message()};
  return images;
}

// The recording says no times; its camera ran at 30 Hz.
FrameTime time_at_30_hz(std::uint64_t frame) {
  return frame_time_from_ns(static_cast<std::int64_t>(frame * 1'000'000'000 / 30));
}

Status read_seven_scenes(Recording& recording) {
  const Result<NumberedImages> images = list_numbered(recording.folder);
  if (!images) return images.error();
  for (const auto& [frame, name] : images->color) {
    const auto depth = images->depth.find(frame);
    if (depth == images->depth.end()) continue;
    const FrameTime time = time_at_30_hz(frame);
    recording.pairs.push_back({{time, name, 0}, {time, depth->second, 0}});
  }
  recording.unmatched = images->color.size() + images->depth.size() - 2 * recording.pairs.size();
  recording.max_depth_is_none = true;
  return success();
}

Status read_associations(Recording& recording) {
  const fs::path path = recording.folder / "associations.txt";
  const Result<std::string> text = read_text_file(path.string(), kMostListBytes);
  if (!text) return text.error();
  recording.color_list = recording.depth_list = "associations.txt";
  PairList list = parse_associations(*text, path.string());
  recording.pairs = std::move(list.pairs);
  recording.problems = std::move(list.problems);
  return success();
}

Status read_lists(Recording& recording, Duration max_dt) {
  recording.color_list = "rgb.txt";
  recording.depth_list = "depth.txt";
  std::vector<ListedImage> images[2];
  for (int i = 0; i < 2; ++i) {
    const fs::path path = recording.folder / (i == 0 ? recording.color_list : recording.depth_list);
    const Result<std::string> text = read_text_file(path.string(), kMostListBytes);
    if (!text) return text.error();
    ImageList list = parse_image_list(*text, path.string());
    images[i] = std::move(list.images);
    std::move(list.problems.begin(), list.problems.end(), std::back_inserter(recording.problems));
  }
  recording.pairs = associate(images[0], images[1], max_dt);
  recording.unmatched = images[0].size() + images[1].size() - 2 * recording.pairs.size();
  return success();
}

Status read_pairs(Recording& recording, Duration max_dt) {
  if (recording.layout == Layout::seven_scenes) return read_seven_scenes(recording);
  const bool lists = present(recording.folder / "rgb.txt") && present(recording.folder / "depth.txt");
  return lists ? read_lists(recording, max_dt) : read_associations(recording);
}

Result<Layout> detect_layout(const fs::path& folder) {
  if (present(folder / "associations.txt") || (present(folder / "rgb.txt") && present(folder / "depth.txt")))
    return Layout::tum;
  const Result<NumberedImages> images = list_numbered(folder);
  if (!images) return images.error();
  if (!images->color.empty()) return Layout::seven_scenes;
  return Error{folder.string(),
               "not a recording: neither rgb.txt and depth.txt, nor associations.txt, nor frame-NNNNNN.color.png"};
}

// What onemapd records says so in the first line of its list.
bool says_own_depth_time(const fs::path& folder) {
  std::ifstream list(folder / "depth.txt");
  std::string first;
  return std::getline(list, first) && first == kOwnDepthTime;
}

// As the data set documents its Kinect.
constexpr std::pair<std::string_view, std::string_view> kSevenScenesCalibration[] = {
    {"fx", "585"}, {"fy", "585"}, {"cx", "320"}, {"cy", "240"}};

Error no_pairs(const Recording& recording) {
  if (!recording.problems.empty()) return recording.problems.front();
  return {recording.folder.string(), "no colour image has a depth image near it in time (" +
                                         std::to_string(recording.unmatched) + " images without a partner)"};
}

Status calibrate(Recording& recording, const ReplayAddress& address) {
  const fs::path path = recording.folder / "calibration.txt";
  const bool seven_scenes = recording.layout == Layout::seven_scenes;
  imaging::Calibration calibration;
  if (present(path)) {
    const Result<std::string> text = read_text_file(path.string(), kMostListBytes);
    if (!text) return text.error();
    if (const Status status = calibration.parse(*text, path.string()); !status) return status.error();
    recording.calibration_source = "calibration.txt";
  } else if (seven_scenes) {
    for (const auto& [key, value] : kSevenScenesCalibration)
      if (const Status status = calibration.set(key, value); !status) return status.error();
    recording.calibration_source = "7-Scenes' documented defaults";
  }
  calibration.replace_with(address.calibration);
  for (const std::string& key : address.calibration.keys())
    recording.calibration_source += (recording.calibration_source.empty() ? "options " : ", ") + key;
  recording.intrinsics.depth_scale = seven_scenes ? 1000 : 5000;
  if (const Status status = calibration.apply(recording.intrinsics); !status)
    return Error{path.string(),
                 status.error().reason + "; write `key value` lines there or give options: ?fx=..&fy=.."};
  recording.calibration = std::move(calibration);
  return success();
}

Status choose_range(Recording& recording, const ReplayAddress& address) {
  const std::size_t count = recording.pairs.size();
  recording.from = 0;
  recording.to = count;
  if (!address.range) return success();
  const auto [from, to] = *address.range;
  if (from >= to || to > count)
    return Error{"camera address '" + address.text + "'", "frames " + std::to_string(from) + " to " +
                                                              std::to_string(to) + " of a recording that has 0 to " +
                                                              std::to_string(count)};
  recording.from = from;
  recording.to = to;
  return success();
}

}  // namespace

Result<Recording> open_recording(const ReplayAddress& address) {
  Recording recording;
  recording.folder = address.folder;
  std::error_code ignored;
  if (!fs::is_directory(recording.folder, ignored))
    return Error{"camera address '" + address.text + "'",
                 "no folder '" + address.folder + "'; expected replay:DIR or replay:DIR:FROM:TO"};
  const Result<Layout> layout = address.layout ? Result<Layout>(*address.layout) : detect_layout(recording.folder);
  if (!layout) return layout.error();
  recording.layout = *layout;
  recording.own_depth_time = address.own_depth_time.value_or(says_own_depth_time(recording.folder));
  for (const Status& status : {read_pairs(recording, address.max_dt), calibrate(recording, address)})
    if (!status) return status.error();
  if (recording.pairs.empty()) return no_pairs(recording);
  if (const Status status = choose_range(recording, address); !status) return status.error();
  return recording;
}

}  // namespace onemap::hal::replay
