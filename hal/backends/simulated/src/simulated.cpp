#include "hal/backends/simulated.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <optional>
#include <thread>

#include "caster.hpp"
#include "house.hpp"
#include "options.hpp"
#include "ring.hpp"
#include "rooms.hpp"
#include "sensor.hpp"
#include "walk.hpp"

namespace onemap::hal {

namespace {

using namespace simulated;

CameraPose pose_at(const Walk& walk, const Options& options, std::uint64_t frame, int late_ms = 0) {
  const double time_s = static_cast<double>(frame) / options.fps + late_ms / 1000.0;
  const int robot = frame < options.carried_at ? options.robot : options.robot % options.robots + 1;
  if (options.scene == SceneName::house) return pose_in_house(robot, options.seed, time_s);
  if (options.scene == SceneName::ring) return pose_in_ring(robot, options.robots, options.seed, time_s);
  return pose_on_walk(walk, robot, options.robots, options.seed, time_s);
}

class SimulatedCamera final : public DepthCamera {
 public:
  explicit SimulatedCamera(const Options& options)
      : options_(options),
        claimed_(options.claimed_intrinsics()),
        scene_(build_scene(options.scene, options.seed)),
        walk_(walk_in(options.scene, options.seed)),
        caster_(scene_, options.intrinsics()),
        sensor_(options),
        row_(options.width) {
    if (options.depth_late_ms != 0) depth_.emplace(scene_, options.intrinsics(), options.width);
  }

  const Intrinsics& intrinsics() const override { return claimed_; }

  Grab grab(Frame& into, std::chrono::milliseconds timeout) override {
    if (unplugged()) return away(timeout);
    if (next_ >= options_.frames) return Grab::end;
    assert(into.depth().size() == static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height));
    draw(options_.faulty(options_.freeze_at, next_) ? options_.freeze_at - 1 : next_, into);
    break_pixels(into);
    into.index = next_;
    into.colour_time =
        options_.time(next_) - (options_.faulty(options_.time_back_at, next_) ? kBack : Duration::zero());
    into.depth_time = into.colour_time + std::chrono::milliseconds(options_.depth_late_ms);
    ++next_;
    ++delivered_;
    return Grab::frame;
  }

  const Error& last_error() const override { return error_; }  // a formula always answers, unless it is unplugged
  CameraCounters counters() const override { return {delivered_, 0, 0, 0}; }
  bool live() const override { return false; }
  std::uint64_t frames_expected() const override { return options_.frames - std::min(next_, options_.frames); }
  std::string description() const override {
    return fmt::format("simulated {}, robot {} of {}, seed {}, {}x{}", options_.scene_text, options_.robot,
                       options_.robots, options_.seed, options_.width, options_.height);
  }

 private:
  static constexpr Duration kBack = std::chrono::hours(1);

  bool unplugged() const {
    return next_ < options_.frames && next_ >= options_.unplug_at && next_ - options_.unplug_at < options_.back_after;
  }
  // Its time goes on.
  Grab away(std::chrono::milliseconds timeout) {
    std::this_thread::sleep_for(timeout);
    next_ += std::max<std::uint64_t>(1, static_cast<std::uint64_t>(timeout.count() * options_.fps / 1000));
    error_ = {fmt::format("simulated {}", options_.scene_text), "unplugged, as its address says"};
    return Grab::gone;
  }
  void draw(std::uint64_t frame, Frame& into) {
    caster_.start(pose_at(walk_, options_, frame));
    if (depth_) depth_->caster.start(pose_at(walk_, options_, frame, options_.depth_late_ms));
    for (int y = 0; y < options_.height; ++y) {
      caster_.cast(y, row_);
      if (depth_) depth_->cast(y, row_);
      sensor_.take(frame, y, row_, into.rgb(), into.depth());
    }
  }
  // A sensor's last bits are noise whatever it sees.
  void break_pixels(Frame& into) {
    if (options_.faulty(options_.black_at, next_))
      for (std::uint8_t& v : into.rgb()) v = static_cast<std::uint8_t>(v & 3);
    if (options_.faulty(options_.saturate_at, next_))
      for (std::uint8_t& v : into.rgb()) v = static_cast<std::uint8_t>(252 | v);
    if (options_.faulty(options_.no_depth_at, next_)) std::ranges::fill(into.depth(), std::uint16_t{0});
  }

  // What depth sees when it is measured at another time than colour.
  struct Depth {
    Depth(const Scene& scene, const Intrinsics& k, int width) : caster(scene, k), row(width) {}
    void cast(int y, Row& into) {
      caster.cast(y, row);
      into.inverse_depth.swap(row.inverse_depth);
      into.weak.swap(row.weak);
    }
    Caster caster;
    Row row;
  };
  const Options options_;
  const Intrinsics claimed_;
  const Scene scene_;
  const Walk walk_;
  Caster caster_;
  Sensor sensor_;
  Row row_;
  std::optional<Depth> depth_;
  std::uint64_t next_ = 0, delivered_ = 0;
  Error error_;
};

}  // namespace

Result<std::unique_ptr<DepthCamera>> open_simulated(const CameraAddress& address) {
  auto options = parse_options(address);
  if (!options) return options.error();
  return std::unique_ptr<DepthCamera>(std::make_unique<SimulatedCamera>(*options));
}

Status check_simulated(const CameraAddress& address) {
  const auto options = parse_options(address);
  return options ? success() : options.error();
}

Result<std::function<SimulatedPose(std::uint64_t)>> simulated_pose(const CameraAddress& address) {
  auto options = parse_options(address);
  if (!options) return options.error();
  const Walk walk = walk_in(options->scene, options->seed);
  return std::function<SimulatedPose(std::uint64_t)>([walk, options = *options](std::uint64_t frame) {
    const CameraPose pose = pose_at(walk, options, frame);
    return SimulatedPose{
        options.time(frame), {pose.position.x, pose.position.y, pose.position.z}, quaternion_xyzw(pose)};
  });
}

Result<std::vector<SimulatedPose>> simulated_truth(const CameraAddress& address) {
  const auto options = parse_options(address);
  const auto pose = simulated_pose(address);
  if (!options || !pose) return options ? pose.error() : options.error();
  std::vector<SimulatedPose> truth;
  truth.reserve(options->frames);
  for (std::uint64_t frame = 0; frame < options->frames; ++frame) truth.push_back((*pose)(frame));
  return truth;
}

}  // namespace onemap::hal
