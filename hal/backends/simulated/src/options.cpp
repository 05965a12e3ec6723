#include "options.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <map>

namespace onemap::hal::simulated {

namespace {

struct NamedScene {
  std::string_view text;
  SceneName name;
};
constexpr std::array<NamedScene, 8> kScenes{{{"living-room", SceneName::living_room},
                                             {"office", SceneName::office},
                                             {"storage", SceneName::storage},
                                             {"empty-hall", SceneName::empty_hall},
                                             {"corridor", SceneName::corridor},
                                             {"house", SceneName::house},
                                             {"ring", SceneName::ring},
                                             {"blank-walls", SceneName::blank_walls}}};
constexpr std::string_view kKeys =
    "robot=1..robots, robots=1..64, frames=1..1000000, seed=0..9223372036854775807, noise=kinect|none, near=0.4..2, "
    "far=1..8, width=64..1920, height=48..1440, fps=1..120, carried_at=1..1000000, "
    "depth_late_ms=-50..50; faults, by frame: unplug_at, back_after, freeze_at, black_at, saturate_at, no_depth_at, "
    "time_back_at, fault_for=1..1000000, fx_scale=0.5..2";

// Takes the options one by one; the first that is wrong is kept, what is left at the end is unknown.
class Reader {
 public:
  explicit Reader(const CameraAddress& address)
      : place_("camera address '" + address.text + "'"), left_(address.options) {}

  template <class T>
  T number(const std::string& key, T fallback, T low, T high) {
    const auto found = left_.find(key);
    if (found == left_.end()) return fallback;
    const std::string text = found->second;
    left_.erase(found);
    T value{};
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code == std::errc{} && end == text.data() + text.size() && value >= low && value <= high) return value;
    fail(fmt::format("{}={}: expected a {} from {} to {}", key, text, std::is_integral_v<T> ? "whole number" : "number",
                     low, high));
    return fallback;
  }

  bool kinect_or_none() {
    const auto found = left_.find("noise");
    if (found == left_.end()) return true;
    const std::string text = found->second;
    left_.erase(found);
    if (text != "kinect" && text != "none") fail(fmt::format("noise={}: expected kinect or none", text));
    return text != "none";
  }

  void fail(const std::string& reason) {
    if (reason_.empty()) reason_ = reason;
  }
  bool failed() {
    if (!left_.empty()) fail(fmt::format("unknown option '{}'; known: {}", left_.begin()->first, kKeys));
    return !reason_.empty();
  }
  Error error() const { return {place_, reason_}; }

 private:
  std::string place_, reason_;
  std::map<std::string, std::string> left_;
};

void read_scene(const std::string& text, Options& options, Reader& reader) {
  std::string known;
  for (const NamedScene& scene : kScenes) {
    if (scene.text == text) {
      options.scene = scene.name;
      options.scene_text = text;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(scene.text);
  }
  reader.fail(fmt::format("no scene '{}'; known: {}", text, known));
}

void read_faults(Options& o, Reader& reader) {
  const auto frame = [&](const char* key, std::uint64_t& at) {
    at = reader.number<std::uint64_t>(key, at, 1, Options::kNever);
  };
  frame("unplug_at", o.unplug_at);
  frame("back_after", o.back_after);
  frame("freeze_at", o.freeze_at);
  frame("black_at", o.black_at);
  frame("saturate_at", o.saturate_at);
  frame("no_depth_at", o.no_depth_at);
  frame("time_back_at", o.time_back_at);
  frame("fault_for", o.fault_for);
  o.fx_scale = reader.number("fx_scale", o.fx_scale, 0.5, 2.0);
}

}  // namespace

Result<Options> parse_options(const CameraAddress& address) {
  Options o;
  Reader reader(address);
  read_scene(address.path, o, reader);
  o.robots = reader.number("robots", o.robots, 1, 64);
  o.robot = reader.number("robot", o.robot, 1, o.robots);
  o.frames = reader.number<std::uint64_t>("frames", o.frames, 1, 1'000'000);
  o.seed = reader.number<std::uint64_t>("seed", o.seed, 0, (std::uint64_t{1} << 63) - 1);
  o.kinect_noise = reader.kinect_or_none();
  o.near_m = reader.number("near", o.near_m, 0.4, 2.0);
  o.far_m = reader.number("far", o.far_m, 1.0, 8.0);
  if (o.far_m <= o.near_m) reader.fail(fmt::format("far={} is not beyond near={}", o.far_m, o.near_m));
  o.width = reader.number("width", o.width, 64, 1920);
  o.height = reader.number("height", o.height, 48, 1440);
  o.fps = reader.number("fps", o.fps, 1, 120);
  o.carried_at = reader.number<std::uint64_t>("carried_at", o.carried_at, 1, 1'000'000);
  o.depth_late_ms = reader.number("depth_late_ms", o.depth_late_ms, -50, 50);
  read_faults(o, reader);
  if (reader.failed()) return reader.error();
  return o;
}

Intrinsics Options::claimed_intrinsics() const {
  Intrinsics k = intrinsics();
  k.fx *= fx_scale;
  k.fy *= fx_scale;
  return k;
}

Intrinsics Options::intrinsics() const {
  Intrinsics k;
  k.width = width;
  k.height = height;
  k.fx = k.fy = 525.0 * width / 640;
  k.cx = (width - 1) / 2.0;
  k.cy = (height - 1) / 2.0;
  return k;
}

FrameTime Options::time(std::uint64_t frame) const {
  constexpr std::int64_t kSecond = 1'000'000'000, kEpoch = 1'600'000'000 * kSecond;
  const auto elapsed = static_cast<std::int64_t>(frame) * kSecond / fps;
  return frame_time_from_ns(kEpoch + (robot - 1) * std::int64_t{11'000'000} + elapsed);
}

}  // namespace onemap::hal::simulated
