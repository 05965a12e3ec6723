#include "address.hpp"

#include <charconv>

#include "hal/backends/replay/lists.hpp"

namespace onemap::hal::replay {

namespace {

constexpr Duration kMaxMaxDt = std::chrono::seconds(1);

// DIR or DIR:FROM:TO; read from the end, since a folder's name may hold colons.
void split(const std::string& path, ReplayAddress& into) {
  into.folder = path;
  const std::size_t second = path.rfind(':');
  if (second == std::string::npos || second == 0) return;
  const std::size_t first = path.rfind(':', second - 1);
  if (first == std::string::npos) return;
  const auto from = parse_count(std::string_view(path).substr(first + 1, second - first - 1));
  const auto to = parse_count(std::string_view(path).substr(second + 1));
  if (!from || !to) return;
  into.folder = path.substr(0, first);
  into.range = std::pair(*from, *to);
}

Status set_option(const std::string& key, const std::string& value, ReplayAddress& into) {
  if (imaging::Calibration::knows(key)) return into.calibration.set(key, value, "camera address '" + into.text + "'");
  if (key == "max_dt") {
    const Result<FrameTime> seconds = parse_time(value);
    if (!seconds) return Error{"", "max_dt: " + seconds.error().reason};
    into.max_dt = seconds->time_since_epoch();
    if (into.max_dt > kMaxMaxDt) return Error{"", "max_dt is more than a second"};
    return success();
  }
  if (key == "layout") {
    if (value != "tum" && value != "7scenes") return Error{"", "layout '" + value + "' is neither tum nor 7scenes"};
    into.layout = value == "tum" ? Layout::tum : Layout::seven_scenes;
    return success();
  }
  if (key == "depth_time") {
    if (value != "own" && value != "colour") return Error{"", "depth_time '" + value + "' is neither own nor colour"};
    into.own_depth_time = value == "own";
    return success();
  }
  return Error{"",
               "unknown option '" + key + "'; known: fx fy cx cy k1 k2 p1 p2 k3 depth_scale max_dt layout depth_time"};
}

}  // namespace

std::optional<std::size_t> parse_count(std::string_view text) {
  std::size_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Result<ReplayAddress> parse_replay_address(const CameraAddress& address) {
  ReplayAddress parsed;
  parsed.text = address.text;
  split(address.path, parsed);
  for (const auto& [key, value] : address.options)
    if (const Status status = set_option(key, value, parsed); !status)
      return Error{"camera address '" + address.text + "'", status.error().reason};
  return parsed;
}

}  // namespace onemap::hal::replay
