#pragma once
// A session for fakenect, libfreenect's stand-in that plays files: what a Kinect v1 would have sent from a simulated
// room, raw disparities and colour.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include "hal/backends/simulated.hpp"
#include "hal/frame_pool.hpp"

namespace onemap::test {

// The inverse of what the simulated sensor and OpenKinect agree on: eighths of a pixel of a 580 px camera with its
// pattern 7.5 cm away.
inline std::uint16_t kinect_disparity(double z_m) {
  if (z_m <= 0) return 2047;
  const long raw = 1090 - std::lround(8 * 580 * 0.075 / z_m);
  return raw >= 0 && raw < 2047 ? static_cast<std::uint16_t>(raw) : std::uint16_t{2047};
}

// Writes `frames` pictures of the room, `hz` of them a second of real time; their stamps are the room's. A depth image
// is depth_late_ticks (of 60 MHz) later than its colour image, and all are `ticks` after the counter's start.
inline void write_kinect_session(const std::string& folder, const std::string& room, int frames, double hz,
                                 std::uint32_t ticks = 1000, std::uint32_t depth_late_ticks = 0) {
  auto camera = hal::open_simulated(*hal::parse_camera_address(room));
  if (!camera) throw std::runtime_error(camera.error().text());
  hal::FramePool pool((*camera)->intrinsics(), 1);
  hal::Frame frame = pool.acquire();
  std::ofstream index(folder + "/INDEX.txt");
  FrameTime first{};
  for (int i = 0; i < frames && (*camera)->grab(frame, {}) == hal::Grab::frame; ++i) {
    if (i == 0) first = frame.colour_time;
    const auto stamp = ticks + static_cast<std::uint32_t>(std::llround((frame.colour_time - first).count() * 0.06));
    const double when = 1000 + i / hz;
    const std::string colour = fmt::format("r-{:.6f}-{}.ppm", when, stamp);
    const std::string depth = fmt::format("d-{:.6f}-{}.pgm", when + 0.001, stamp + depth_late_ticks);
    std::ofstream ppm(folder + "/" + colour, std::ios::binary), pgm(folder + "/" + depth, std::ios::binary);
    ppm << "P6 640 480 255\n";
    ppm.write(reinterpret_cast<const char*>(frame.rgb().data()), static_cast<std::streamsize>(frame.rgb().size()));
    pgm << "P5 640 480 65535\n";
    for (const std::uint16_t value : frame.depth()) {
      const std::uint16_t raw = kinect_disparity(value / (*camera)->intrinsics().depth_scale);
      pgm.put(static_cast<char>(raw & 255)).put(static_cast<char>(raw >> 8));
    }
    index << colour << "\n" << depth << "\n";
  }
}

}  // namespace onemap::test
