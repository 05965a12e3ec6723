#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/frame.hpp"

// Which pixels of the colour image the readings of a row of the depth image cover: the inner loop of DepthRegistration.
namespace onemap::hal::imaging::footprints {

inline constexpr int kWidest_px = 64;  // of what one reading covers: more is no surface but two cameras that look apart

// The lens of the colour camera in single precision: a twin of pixel_of() that becomes vectors, tested equal to it.
struct ColourLens {
  explicit ColourLens(const Intrinsics& k);
  bool distorted;
  float fx, fy, cx, cy, k1, k2, p1, p2, k3;
  float widest;  // squared distance of the image's farthest ray from the axis: the lens says nothing beyond
};

// What all rows have in common.
struct Rig {
  ColourLens lens;
  std::array<float, 3> t_m;
  float metres, offset_m;  // of a depth value, and added to it
  float scale;             // colour's depth values of a metre
  float finer_u, finer_v;  // colour pixels of a depth pixel at the same distance
  float nearest_m;
  float too_far;       // the first depth value that is none
  std::int32_t least;  // the first that is one
  std::int32_t width, height;
};

// A row's readings and their rays, turned into the colour camera's frame.
struct Row {
  std::span<const std::uint16_t> depth;
  const float *ray_x, *ray_y, *ray_z;
};

// Of each reading the first pixel (row by row), or kNowhere; the pixels in x and in y (1 to kWidest_px, in the low and
// the high byte); and its depth there less 1.
inline constexpr std::int32_t kNowhere = -1;
struct Covered {
  explicit Covered(std::size_t width) : first(width), size(width), less_1(width) {}
  std::vector<std::int32_t> first;
  std::vector<std::uint16_t> size, less_1;
  std::int32_t readings = 0, seen = 0;  // those that are some, and of them those that cover something
};

// Writes all of out.
void find_plain(const Rig& rig, const Row& row, Covered& out);
void find_simd(const Rig& rig, const Row& row, Covered& out);  // where simd_available()

}  // namespace onemap::hal::imaging::footprints
