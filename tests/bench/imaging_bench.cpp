// What a camera's images cost before the map sees them: raw colour to RGB, MJPEG, depth onto colour's pixels. The peers
// in the same run: OpenCV's cvtColor and imdecode, and librealsense's alignment. The counter says the part of a core
// that this takes at 30 images a second, in per cent.
#include <benchmark/benchmark.h>

#ifdef ONEMAP_HAVE_OPENCV
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#endif

#include <vector>

#include "align_peer.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/imaging/encode_image.hpp"
#include "hal/imaging/image_file.hpp"
#include "hal/imaging/raw_colour.hpp"
#include "hal/imaging/raw_depth.hpp"

namespace {

using namespace onemap;
using namespace onemap::hal;

struct Picture {
  Intrinsics k;
  std::vector<std::uint8_t> rgb, yuyv;
  std::vector<std::uint16_t> depth;
};

Picture picture(int width, int height) {
  const std::string address =
      "simulated:living-room?seed=3&frames=1&width=" + std::to_string(width) + "&height=" + std::to_string(height);
  const auto camera = open_simulated(*parse_camera_address(address)).value();
  FramePool pool(camera->intrinsics(), 1);
  Frame frame = pool.acquire();
  Picture out;
  out.k = camera->intrinsics();
  if (camera->grab(frame, {}) != Grab::frame) return out;
  out.rgb.assign(frame.rgb().begin(), frame.rgb().end());
  out.depth.assign(frame.depth().begin(), frame.depth().end());
  for (std::size_t i = 0; i < out.rgb.size(); i += 3) {  // luma and chroma of the picture, roughly
    const int r = out.rgb[i], g = out.rgb[i + 1], b = out.rgb[i + 2], y = (r + 2 * g + b) / 4;
    out.yuyv.push_back(static_cast<std::uint8_t>(16 + y * 219 / 255));
    out.yuyv.push_back(static_cast<std::uint8_t>(128 + ((i / 3) % 2 == 0 ? b - y : r - y) / 2));
  }
  return out;
}

std::vector<std::uint8_t> jpeg_of(const Picture& in) {
  std::vector<std::uint8_t> file;
  if (!imaging::encode_jpeg({in.k.width, in.k.height}, in.rgb, 85, file)) file.clear();
  return file;
}

void count(benchmark::State& state) {
  state.counters["core_%"] =
      benchmark::Counter(1.0 / 3000, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

int width_of(const benchmark::State& state) { return static_cast<int>(state.range(0)); }
int height_of(const benchmark::State& state) { return static_cast<int>(state.range(1)); }

void yuyv(benchmark::State& state) {
  const Picture in = picture(width_of(state), height_of(state));
  std::vector<std::uint8_t> rgb(in.rgb.size());
  for ([[maybe_unused]] auto _ : state) {
    if (!imaging::yuyv_to_rgb({in.yuyv, {in.k.width, in.k.height}}, rgb)) state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(rgb.data());
  }
  count(state);
}

void bayer(benchmark::State& state) {
  const Picture in = picture(width_of(state), height_of(state));
  std::vector<std::uint8_t> rgb(in.rgb.size());
  const std::span<const std::uint8_t> mosaic(in.rgb.data(), in.rgb.size() / 3);
  for ([[maybe_unused]] auto _ : state) {
    if (!imaging::bayer_grbg_to_rgb({mosaic, {in.k.width, in.k.height}}, rgb)) state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(rgb.data());
  }
  count(state);
}

void packed_disparity(benchmark::State& state) {
  const std::vector<std::uint8_t> packed(640 * 480 / 8 * 11, 0x5a);
  std::vector<std::uint16_t> mm(std::size_t{640} * 480);
  const imaging::KinectDisparity kinect;
  for ([[maybe_unused]] auto _ : state) {
    if (!kinect.packed_to_mm({packed, {640, 480}}, mm)) state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(mm.data());
  }
  count(state);
}

void mjpeg(benchmark::State& state) {
  const Picture in = picture(width_of(state), height_of(state));
  const std::vector<std::uint8_t> file = jpeg_of(in);
  std::vector<std::uint8_t> rgb(in.rgb.size());
  for ([[maybe_unused]] auto _ : state) {
    if (!imaging::decode_color(file, {in.k.width, in.k.height}, rgb, imaging::Chroma::plain))
      state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(rgb.data());
  }
  count(state);
}

// A depth lens 25 mm to the left of colour's; its image is the room's own, as if it stood there.
struct Lenses {
  Picture in;
  Intrinsics colour;
  imaging::ColourFromDepth pose{.translation_m = {-0.025, 0.001, 0}};
};

Lenses lenses(const benchmark::State& state) {
  Lenses out;
  out.in = picture(width_of(state), height_of(state));
  out.colour = out.in.k;
  out.colour.width = static_cast<int>(state.range(2));
  out.colour.height = static_cast<int>(state.range(3));
  const double finer = static_cast<double>(out.colour.width) / out.in.k.width;
  out.colour.fx = out.colour.fy = finer * out.in.k.fx;
  out.colour.cx = (out.colour.width - 1) / 2.0;
  out.colour.cy = (out.colour.height - 1) / 2.0;
  return out;
}

void registered(benchmark::State& state) {
  const Lenses in = lenses(state);
  std::vector<std::uint16_t> out(static_cast<std::size_t>(in.colour.width * in.colour.height));
  imaging::DepthRegistration registration(in.in.k, in.colour, in.pose);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(registration.apply(in.in.depth, out));
  count(state);
}

// Two pinholes beside each other that look the same way, as nominal calibrations say; the last number is the depth
// lens's focal length in hundredths of colour's.
void registered_sideways(benchmark::State& state) {
  Lenses in = lenses(state);
  in.pose = {.translation_m = {-0.025, 0, 0}};
  in.in.k.fx = in.in.k.fy = in.colour.fx * static_cast<double>(state.range(4)) / 100;
  std::vector<std::uint16_t> out(static_cast<std::size_t>(in.colour.width * in.colour.height));
  imaging::DepthRegistration registration(in.in.k, in.colour, in.pose);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(registration.apply(in.in.depth, out));
  count(state);
}

void registered_with_lens(benchmark::State& state) {
  Lenses in = lenses(state);
  in.colour.k1 = 0.1, in.colour.k2 = -0.2, in.colour.p1 = 0.001;
  std::vector<std::uint16_t> out(static_cast<std::size_t>(in.colour.width * in.colour.height));
  imaging::DepthRegistration registration(in.in.k, in.colour, in.pose);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(registration.apply(in.in.depth, out));
  count(state);
}

void registered_by_librealsense(benchmark::State& state) {
  const Lenses in = lenses(state);
  std::vector<std::uint16_t> out(static_cast<std::size_t>(in.colour.width * in.colour.height));
  const test::AlignPeer peer{in.in.k, in.colour, in.pose};
  for ([[maybe_unused]] auto _ : state) {
    peer.apply(in.in.depth, out);
    benchmark::DoNotOptimize(out.data());
  }
  count(state);
}

// A whole frame of the V4L2 backend: YUYV, and depth with the nominal lenses of a RealSense D435.
void v4l2_frame(benchmark::State& state) {
  Picture in = picture(640, 480);
  in.k.fx = in.k.fy = 383;
  Intrinsics colour = in.k;
  colour.fx = colour.fy = 615;
  const imaging::ColourFromDepth pose{.translation_m = {0.0148, 0, 0}};
  imaging::DepthRegistration registration(in.k, colour, pose);
  std::vector<std::uint16_t> depth(in.depth.size());
  std::vector<std::uint8_t> rgb(in.rgb.size());
  for ([[maybe_unused]] auto _ : state) {
    if (!imaging::yuyv_to_rgb({in.yuyv, {in.k.width, in.k.height}}, rgb)) state.SkipWithError("not decoded");
    benchmark::DoNotOptimize(registration.apply(in.depth, depth));
  }
  count(state);
}

#ifdef ONEMAP_HAVE_OPENCV
void yuyv_by_opencv(benchmark::State& state) {
  Picture in = picture(width_of(state), height_of(state));
  const cv::Mat raw(in.k.height, in.k.width, CV_8UC2, in.yuyv.data());
  cv::Mat rgb;
  for ([[maybe_unused]] auto _ : state) {
    cv::cvtColor(raw, rgb, cv::COLOR_YUV2RGB_YUY2);
    benchmark::DoNotOptimize(rgb.data);
  }
  count(state);
}

void mjpeg_by_opencv(benchmark::State& state) {
  const Picture in = picture(width_of(state), height_of(state));
  const std::vector<std::uint8_t> file = jpeg_of(in);
  cv::Mat bgr;
  for ([[maybe_unused]] auto _ : state) {
    cv::imdecode(file, cv::IMREAD_COLOR, &bgr);
    benchmark::DoNotOptimize(bgr.data);
  }
  count(state);
}
BENCHMARK(yuyv_by_opencv)->Args({640, 480})->Args({1280, 720});
BENCHMARK(mjpeg_by_opencv)->Args({640, 480});
#endif

BENCHMARK(yuyv)->Args({640, 480})->Args({1280, 720});
BENCHMARK(bayer)->Args({640, 480});
BENCHMARK(packed_disparity);
BENCHMARK(mjpeg)->Args({640, 480});
BENCHMARK(v4l2_frame);
BENCHMARK(registered)->Args({640, 480, 640, 480})->Args({848, 480, 1280, 720});
BENCHMARK(registered_sideways)
    ->Args({640, 480, 640, 480, 110})
    ->Args({640, 480, 640, 480, 62})
    ->Args({848, 480, 1280, 720, 46});
BENCHMARK(registered_with_lens)->Args({640, 480, 640, 480});
BENCHMARK(registered_by_librealsense)->Args({640, 480, 640, 480})->Args({848, 480, 1280, 720});

}  // namespace

int main(int argc, char** argv) {
#ifdef ONEMAP_HAVE_OPENCV
  cv::setNumThreads(1);
#endif
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
