#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"
#include "mapping/geometry.hpp"

namespace onemap::mapping {

// An organised cloud on an ideal pinhole grid (no distortion): the target of projective association. Cell (u, v) looks
// along ((u - cx) / fx, (v - cy) / fy, 1). Invalid cells have z = 0 (points) or zero length (normals).
struct OrganizedCloud {
  int width = 0, height = 0;
  float fx = 0, fy = 0, cx = 0, cy = 0;
  std::vector<Vector3f> points;   // camera frame, metres
  std::vector<Vector3f> normals;  // unit, towards the camera
  hal::DepthNoise noise;          // of the camera that saw it, before organize()
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }

  // What organize() keeps for the next image of the same camera: the pixels that a cell reads (-1: outside the image),
  // the ray through their middle, and 1 / z of each cell (0: invalid).
  struct Sampling {
    std::int32_t first_pixel = -1;
    float x = 0, y = 0;
  };
  hal::Intrinsics camera{.width = 0, .height = 0};
  std::vector<Sampling> sampling;
  std::vector<float> inverse_depth;
};

// Builds a width x height organised cloud from a depth image, eq. (5): each cell takes the mean of the depths of one
// surface in the block of pixels (intrinsics.width / width wide) about the pixel where its ray falls, which averages
// the sensor's quantisation, at the ray through the middle of that block (at most half a pixel from the cell's own
// ray). Normals from a plane fit over 5 x 5 cells, none across depth steps. The grid spans the colour image's field of
// view (fx = width / intrinsics.width * intrinsics.fx, ...). out's memory is reused: no allocation after the first
// call.
// T_colour_depth: how the camera moved since depth was measured; the cloud is as it looks from where it came to.
void organize(std::span<const std::uint16_t> depth, const hal::Intrinsics& intrinsics, int width, int height,
              OrganizedCloud& out, const std::optional<Pose>& T_colour_depth = {});

// The cloud of depths that are on an ideal grid already: out's width, height and pinhole are set, depth_m has a value a
// cell (0: none). Without normals where nothing is aligned to it: they are most of the work.
enum class Normals : std::uint8_t { none, fitted };
void organize_grid(std::span<const float> depth_m, Normals normals, OrganizedCloud& out);

}  // namespace onemap::mapping
