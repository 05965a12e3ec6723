#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "caster.hpp"
#include "options.hpp"

namespace onemap::hal::simulated {

// Turns what a frame sees into what a camera delivers. Noise is a table of Gaussian numbers read from a place that a
// hash of (seed, robot, frame, row) chooses: frame k is the same whatever came before it.
class Sensor {
 public:
  explicit Sensor(const Options& options);
  // The rows of frame `frame`, from 0 to height-1, into the frame's pictures.
  void take(std::uint64_t frame, int y, const Row& row, std::span<std::uint8_t> rgb, std::span<std::uint16_t> depth);

 private:
  const std::int16_t* noise(std::uint64_t frame, int y, std::uint64_t which) const;
  void exact_depth(const Row& row, std::uint16_t* depth) const;
  void kinect_depth(const Row& row, const std::int16_t* noise, std::uint16_t* depth) const;
  void blur_along(const Row& row, std::uint16_t* out) const;
  void deliver_colour(std::uint64_t frame, int y, int above, int below, std::uint8_t* rgb) const;

  const Options options_;
  const std::size_t width_;
  const float pattern_px_;  // pixels of the colour image by which 1/m of inverse depth moves the pattern
  std::uint64_t key_;
  std::vector<std::int16_t> gauss_;      // sigma 1024
  std::vector<std::uint16_t> depth_of_;  // depth value of a disparity in eighths of a pixel
  std::vector<std::uint16_t> fade_x_, fade_y_;
  std::vector<std::uint16_t> blurred_;  // three rows, blurred along the row, times 8
};

}  // namespace onemap::hal::simulated
