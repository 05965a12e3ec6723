#include "hal/backends/simulated.hpp"

#include <fmt/format.h>

#include <cassert>
#include <optional>

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
        intrinsics_(options.intrinsics()),
        scene_(build_scene(options.scene, options.seed)),
        walk_(walk_in(options.scene, options.seed)),
        caster_(scene_, intrinsics_),
        sensor_(options),
        row_(options.width) {
    if (options.depth_late_ms != 0) depth_.emplace(scene_, intrinsics_, options.width);
  }

  const Intrinsics& intrinsics() const override { return intrinsics_; }

  Grab grab(Frame& into, std::chrono::milliseconds) override {
    if (next_ == options_.frames) return Grab::end;
    assert(into.depth().size() == static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height));
    caster_.start(pose_at(walk_, options_, next_));
    if (depth_) depth_->caster.start(pose_at(walk_, options_, next_, options_.depth_late_ms));
    for (int y = 0; y < options_.height; ++y) {
      caster_.cast(y, row_);
      if (depth_) depth_->cast(y, row_);
      sensor_.take(next_, y, row_, into.rgb(), into.depth());
    }
    into.index = next_;
    into.colour_time = options_.time(next_);
    into.depth_time = into.colour_time + std::chrono::milliseconds(options_.depth_late_ms);
    ++next_;
    return Grab::frame;
  }

  const Error& last_error() const override { return no_error_; }  // a formula always answers
  CameraCounters counters() const override { return {next_, 0, 0, 0}; }
  bool live() const override { return false; }
  std::uint64_t frames_expected() const override { return options_.frames - next_; }
  std::string description() const override {
    return fmt::format("simulated {}, robot {} of {}, seed {}, {}x{}", options_.scene_text, options_.robot,
                       options_.robots, options_.seed, options_.width, options_.height);
  }

 private:
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
  const Intrinsics intrinsics_;
  const Scene scene_;
  const Walk walk_;
  Caster caster_;
  Sensor sensor_;
  Row row_;
  std::optional<Depth> depth_;
  std::uint64_t next_ = 0;
  Error no_error_;
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

Result<std::vector<SimulatedPose>> simulated_truth(const CameraAddress& address) {
  auto options = parse_options(address);
  if (!options) return options.error();
  const Walk walk = walk_in(options->scene, options->seed);
  std::vector<SimulatedPose> truth;
  truth.reserve(options->frames);
  for (std::uint64_t frame = 0; frame < options->frames; ++frame) {
    const CameraPose pose = pose_at(walk, *options, frame);
    truth.push_back({options->time(frame), {pose.position.x, pose.position.y, pose.position.z}, quaternion_xyzw(pose)});
  }
  return truth;
}

}  // namespace onemap::hal
