// The whole frame path on a recording, on one core: milliseconds of processor time a frame with every step's share,
// memory, allocations; beside OpenCV's RgbdOdometry (opencv_contrib) on the same frames in the same run, when that is
// installed.
//   pipeline_bench SEQUENCE [--frames N] [--every N] [--trajectory FILE] [--no-peer]
#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "hal/backends.hpp"
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/base/file.hpp"
#include "hal/frame_pool.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/count_allocations.hpp"
#include "support/submap_digest.hpp"
#ifdef ONEMAP_WITH_OPENCV_RGBD
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd.hpp>
#endif

namespace {

using namespace onemap;
// Processor time of this thread: on a shared machine the wall clock measures the neighbours.
struct Clock {
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<Clock, duration>;
  static time_point now() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return time_point(duration(t.tv_sec * 1'000'000'000ll + t.tv_nsec));
  }
};

double ms_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

struct StepTimes {
  std::array<double, mapping::kSteps> ms{};
  mapping::Step at = mapping::Step::count;
  Clock::time_point since;
  static void begin(void* context, mapping::Step step) {
    auto& self = *static_cast<StepTimes*>(context);
    const auto now = Clock::now();
    if (self.at != mapping::Step::count) self.ms[static_cast<std::size_t>(self.at)] += ms_between(self.since, now);
    self.at = step;
    self.since = now;
  }
};

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

double mean(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return v.empty() ? 0 : sum / static_cast<double>(v.size());
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

unsigned long long number(std::uint64_t n) { return n; }  // as printf wants it

struct Options {
  std::string address, trajectory;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max(), every = 1;
  bool peer = true;
};

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--frames" && more)
      o.most = std::stoull(argv[++i]);
    else if (word == "--every" && more)
      o.every = std::stoull(argv[++i]);
    else if (word == "--trajectory" && more)
      o.trajectory = argv[++i];
    else if (word == "--no-peer")
      o.peer = false;
    else
      o.address = word;
  }
  if (o.address.find(':') == std::string::npos) o.address = "replay:" + o.address;
  return o;
}

// OpenCV's odometry between one frame and the next.
class Peer {
 public:
#ifdef ONEMAP_WITH_OPENCV_RGBD
  explicit Peer(const hal::Intrinsics& k) : k_(k) {
    cv::setNumThreads(0);
    odometry_ = cv::rgbd::RgbdOdometry::create((cv::Mat_<float>(3, 3) << k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1));
  }
  void process(hal::Frame& frame) {
    const cv::Mat rgb(k_.height, k_.width, CV_8UC3, frame.rgb().data()),
        raw(k_.height, k_.width, CV_16UC1, frame.depth().data());
    cv::Mat gray, depth;
    cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
    raw.convertTo(depth, CV_32F, 1 / k_.depth_scale);
    depth.setTo(std::numeric_limits<float>::quiet_NaN(), depth == 0);
    const auto start = Clock::now();
    auto now = cv::rgbd::OdometryFrame::create(gray, depth);
    cv::Mat Rt;
    if (before_) odometry_->compute(before_, now, Rt);
    if (before_) ms_.push_back(ms_between(start, Clock::now()));
    before_ = now;
  }
  void report(const std::vector<double>& ours_ms) const {
    std::printf("OpenCV RgbdOdometry median %.3f p95 %.3f ms; ours / theirs %.2f (medians)\n", quantile(ms_, 0.5),
                quantile(ms_, 0.95), quantile(ours_ms, 0.5) / quantile(ms_, 0.5));
  }

 private:
  const hal::Intrinsics k_;
  cv::Ptr<cv::rgbd::RgbdOdometry> odometry_;
  cv::Ptr<cv::rgbd::OdometryFrame> before_;
  std::vector<double> ms_;
#else
  explicit Peer(const hal::Intrinsics&) {}
  void process(hal::Frame&) {}
  void report(const std::vector<double>&) const {}
#endif
};

class Bench {
 public:
  explicit Bench(const hal::Intrinsics& k) : mapper_(config_, k) {
    mapping::LocalMapper::reserve_record(keyframe_, config_);
    poses_.poses.reserve(256);
    mapper_.set_step_hook({&StepTimes::begin, &steps_});
  }

  void process(const hal::FrameView& frame) {
    steps_ = {};
    const std::uint64_t before = test::allocations();
    const auto start = Clock::now();
    const mapping::FrameReport report = mapper_.process(frame);
    const auto stop = Clock::now();
    if (!frame_ms_.empty()) allocations_ += test::allocations() - before;
    frame_ms_.push_back(ms_between(start, stop));
    for (std::size_t s = 0; s < mapping::kSteps; ++s) step_ms_[s].push_back(steps_.ms[s]);
    if (report.state == mapping::TrackState::lost)
      std::fprintf(stderr, "frame %zu lost: %s (features %d matches %d inliers %d)\n", frame_ms_.size() - 1,
                   std::string(to_string(report.reason)).c_str(), report.features, report.matches, report.inliers);
    drain();
  }
  void finish() {
    mapper_.finish();
    drain();
  }

  std::size_t frames() const { return frame_ms_.size(); }
  const std::vector<double>& frame_ms() const { return frame_ms_; }
  const std::vector<mapping::StampedPose>& poses() const { return all_; }
  bool tracked() const { return mapper_.counters().tracked > 0; }

  void report() const {
    std::printf("%-12s %8s %8s %8s\n", "step", "median", "p95", "mean ms");
    for (std::size_t s = 0; s < mapping::kSteps; ++s)
      line(std::string(to_string(static_cast<mapping::Step>(s))), step_ms_[s]);
    line("frame", frame_ms_);
    const mapping::LocalMapperCounters c = mapper_.counters();
    std::printf(
        "frames %llu tracked %llu keyframes %llu times lost %llu relocalized %llu integrated %llu blocks %zu submaps "
        "%zu\n",
        number(c.frames), number(c.tracked), number(c.keyframes), number(c.times_lost), number(c.relocalized),
        number(c.integrated), c.blocks, static_cast<std::size_t>(c.surface.submaps));
    std::printf("allocations on the frame path %llu, mapper %.1f MB, peak RSS %.1f MB, digest %016llx\n",
                number(allocations_), static_cast<double>(mapper_.bytes()) / 1048576, peak_rss_mb(),
                number(test::submap_digest(mapper_)));
  }

 private:
  static void line(const std::string& name, const std::vector<double>& ms) {
    std::printf("%-12s %8.3f %8.3f %8.3f\n", name.c_str(), quantile(ms, 0.5), quantile(ms, 0.95), mean(ms));
  }
  void drain() {
    while (mapper_.take_keyframe(keyframe_)) {
    }
    while (mapper_.take_poses(poses_)) all_.insert(all_.end(), poses_.poses.begin(), poses_.poses.end());
  }

  const mapping::LocalMapperConfig config_{};
  mapping::LocalMapper mapper_;
  mapping::KeyframeRecord keyframe_;
  mapping::TrajectoryRecord poses_;
  StepTimes steps_;
  std::vector<double> frame_ms_;
  std::array<std::vector<double>, mapping::kSteps> step_ms_;
  std::vector<mapping::StampedPose> all_;
  std::uint64_t allocations_ = 0;
};

// Every so many frames of the camera, so many at most.
void play(hal::DepthCamera& camera, const Options& options, Bench& bench, Peer& peer) {
  hal::FramePool pool(camera.intrinsics(), 2);
  for (std::uint64_t grabbed = 0; bench.frames() < options.most;) {
    hal::Frame frame = pool.acquire();
    const hal::Grab grab = camera.grab(frame, std::chrono::milliseconds(1000));
    if (grab == hal::Grab::end) return;
    if (grab != hal::Grab::frame || grabbed++ % options.every != 0) continue;
    bench.process(frame.view());
    if (options.peer) peer.process(frame);
  }
}

// TUM's lines.
std::string text_of(const std::vector<mapping::StampedPose>& poses) {
  std::string text;
  for (const mapping::StampedPose& p : poses) {
    const mapping::Pose T = mapping::from_quantized(p.T_robot_camera);
    const auto q = mapping::to_quaternion_wxyz(T.R);
    const auto us = p.time.time_since_epoch().count() / 1000;
    text += fmt::format("{}.{:06} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", us / 1000000, us % 1000000,
                        T.t.x(), T.t.y(), T.t.z(), q[1], q[2], q[3], q[0]);
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  const std::array<hal::Backend, 2> table{{{"replay", "", hal::open_replay}, {"simulated", "", hal::open_simulated}}};
  auto camera = hal::open_camera(table, options.address);
  if (!camera) return std::fprintf(stderr, "%s\n", camera.error().text().c_str()), 1;
  Bench bench((*camera)->intrinsics());
  Peer peer((*camera)->intrinsics());
  play(**camera, options, bench, peer);
  bench.finish();
  if (!options.trajectory.empty())
    if (const auto written = write_text_file(options.trajectory, text_of(bench.poses())); !written)
      return std::fprintf(stderr, "%s\n", written.error().text().c_str()), 1;
  bench.report();
  if (options.peer) peer.report(bench.frame_ms());
  return bench.tracked() ? 0 : 1;
}
