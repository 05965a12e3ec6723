// The whole frame path on a recording, on one core: milliseconds of processor time a frame with every step's share,
// memory, allocations; beside OpenCV's RgbdOdometry (opencv_contrib) on the same frames in the same run, when that is
// installed.
//   pipeline_bench SEQUENCE [--frames N] [--every N] [--trajectory FILE] [--no-peer]
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "hal/backends.hpp"
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "mapping/local/local_mapper.hpp"
#include "support/count_allocations.hpp"
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

struct StepTimes {
  std::array<double, mapping::kSteps> ms{};
  mapping::Step at = mapping::Step::count;
  Clock::time_point since;
  static void begin(void* context, mapping::Step step) {
    auto& self = *static_cast<StepTimes*>(context);
    const auto now = Clock::now();
    if (self.at != mapping::Step::count)
      self.ms[static_cast<std::size_t>(self.at)] += std::chrono::duration<double, std::milli>(now - self.since).count();
    self.at = step;
    self.since = now;
  }
};

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void write_pose(FILE* file, const mapping::StampedPose& p) {
  const mapping::Pose T = mapping::from_quantized(p.T_robot_camera);
  const auto q = mapping::to_quaternion_wxyz(T.R);
  const auto us = p.time.time_since_epoch().count() / 1000;
  std::fprintf(file, "%lld.%06lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", static_cast<long long>(us / 1000000),
               static_cast<long long>(us % 1000000), T.t.x(), T.t.y(), T.t.z(), q[1], q[2], q[3], q[0]);
}

}  // namespace

int main(int argc, char** argv) {
  std::string address, trajectory;
  std::uint64_t most = ~0ull, every = 1, grabbed = 0;
  bool peer = true;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--frames") && i + 1 < argc)
      most = std::stoull(argv[++i]);
    else if (!std::strcmp(argv[i], "--every") && i + 1 < argc)
      every = std::stoull(argv[++i]);
    else if (!std::strcmp(argv[i], "--trajectory") && i + 1 < argc)
      trajectory = argv[++i];
    else if (!std::strcmp(argv[i], "--no-peer"))
      peer = false;
    else
      address = argv[i];
  }
  if (address.find(':') == std::string::npos) address = "replay:" + address;
  const std::array<hal::Backend, 2> table{{{"replay", "", hal::open_replay}, {"simulated", "", hal::open_simulated}}};
  auto camera = hal::open_camera(table, address);
  if (!camera) return std::fprintf(stderr, "%s\n", camera.error().text().c_str()), 1;
  const hal::Intrinsics k = (*camera)->intrinsics();
  hal::FramePool pool(k, 2);
  mapping::LocalMapperConfig config;
  mapping::LocalMapper mapper(config, k);
  mapping::KeyframeRecord keyframe;
  mapping::LocalMapper::reserve_record(keyframe, config);
  mapping::TrajectoryRecord poses;
  poses.poses.reserve(256);
  StepTimes steps;
  mapper.set_step_hook({&StepTimes::begin, &steps});

#ifdef ONEMAP_WITH_OPENCV_RGBD
  cv::setNumThreads(0);
  const cv::Mat K = (cv::Mat_<float>(3, 3) << k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
  auto odometry = cv::rgbd::RgbdOdometry::create(K);
  cv::Ptr<cv::rgbd::OdometryFrame> before;
  std::vector<double> peer_ms;
#endif
  std::vector<double> frame_ms;
  std::vector<mapping::StampedPose> all;
  std::array<std::vector<double>, mapping::kSteps> step_ms;
  std::uint64_t allocations = 0, frames = 0;
  const auto drain = [&] {
    while (mapper.take_keyframe(keyframe)) {
    }
    while (mapper.take_poses(poses)) all.insert(all.end(), poses.poses.begin(), poses.poses.end());
  };
  for (;;) {
    hal::Frame frame = pool.acquire();
    const hal::Grab grab = (*camera)->grab(frame, std::chrono::milliseconds(1000));
    if (grab == hal::Grab::end || frames >= most) break;
    if (grab != hal::Grab::frame || grabbed++ % every != 0) continue;
    ++frames;
    steps.ms = {};
    steps.at = mapping::Step::count;
    const std::uint64_t before_count = test::allocations();
    const auto start = Clock::now();
    const mapping::FrameReport report = mapper.process(frame.view());
    const auto stop = Clock::now();
    if (frames > 1) allocations += test::allocations() - before_count;
    frame_ms.push_back(std::chrono::duration<double, std::milli>(stop - start).count());
    for (std::size_t s = 0; s < mapping::kSteps; ++s) step_ms[s].push_back(steps.ms[s]);
    if (report.state == mapping::TrackState::lost)
      std::fprintf(stderr, "frame %llu lost: %s (features %d matches %d inliers %d)\n",
                   static_cast<unsigned long long>(frames - 1), std::string(to_string(report.reason)).c_str(),
                   report.features, report.matches, report.inliers);
    drain();
#ifdef ONEMAP_WITH_OPENCV_RGBD
    if (peer) {
      const cv::Mat rgb(k.height, k.width, CV_8UC3, frame.rgb().data()),
          raw(k.height, k.width, CV_16UC1, frame.depth().data());
      cv::Mat gray, depth;
      cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
      raw.convertTo(depth, CV_32F, 1 / k.depth_scale);
      depth.setTo(std::numeric_limits<float>::quiet_NaN(), depth == 0);
      const auto t0 = Clock::now();
      auto now = cv::rgbd::OdometryFrame::create(gray, depth);
      cv::Mat Rt;
      if (before) odometry->compute(before, now, Rt);
      if (before) peer_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - t0).count());
      before = now;
    }
#endif
  }
  mapper.finish();
  drain();
  if (!trajectory.empty()) {
    FILE* file = std::fopen(trajectory.c_str(), "w");
    if (!file) return std::perror(trajectory.c_str()), 1;
    for (const auto& p : all) write_pose(file, p);
    std::fclose(file);
  }
  const auto& c = mapper.counters();
  double total = 0;
  for (double ms : frame_ms) total += ms;
  std::printf("%-12s %8s %8s %8s\n", "step", "median", "p95", "mean ms");
  for (std::size_t s = 0; s < mapping::kSteps; ++s) {
    double sum = 0;
    for (double ms : step_ms[s]) sum += ms;
    std::printf("%-12s %8.3f %8.3f %8.3f\n", std::string(to_string(static_cast<mapping::Step>(s))).c_str(),
                quantile(step_ms[s], 0.5), quantile(step_ms[s], 0.95), sum / static_cast<double>(frames));
  }
  std::printf("%-12s %8.3f %8.3f %8.3f\n", "frame", quantile(frame_ms, 0.5), quantile(frame_ms, 0.95),
              total / static_cast<double>(frames));
  std::printf(
      "frames %llu tracked %llu keyframes %llu times lost %llu relocalized %llu integrated %llu blocks %zu/%zu\n",
      static_cast<unsigned long long>(c.frames), static_cast<unsigned long long>(c.tracked),
      static_cast<unsigned long long>(c.keyframes), static_cast<unsigned long long>(c.times_lost),
      static_cast<unsigned long long>(c.relocalized), static_cast<unsigned long long>(c.integrated),
      mapper.map().used(), mapper.map().capacity());
  std::printf("allocations on the frame path %llu, mapper %.1f MB, peak RSS %.1f MB, digest %016llx\n",
              static_cast<unsigned long long>(allocations), static_cast<double>(mapper.bytes()) / 1048576,
              peak_rss_mb(), static_cast<unsigned long long>(mapper.map().digest()));
#ifdef ONEMAP_WITH_OPENCV_RGBD
  if (peer)
    std::printf("OpenCV RgbdOdometry median %.3f p95 %.3f ms; ours / theirs %.2f (medians)\n", quantile(peer_ms, 0.5),
                quantile(peer_ms, 0.95), quantile(frame_ms, 0.5) / quantile(peer_ms, 0.5));
#endif
  return c.tracked > 0 ? 0 : 1;
}
