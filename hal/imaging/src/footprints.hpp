#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/base/twin.hpp"
#include "hal/frame.hpp"

// Which pixels of the colour image the readings of a row of the depth image cover: the inner loop of DepthRegistration.
namespace onemap::hal::imaging::footprints {

inline constexpr int kWidest_px = 64;  // of what one reading covers: more is no surface but two cameras that look apart

// Neighbouring readings of a slanted surface move by a little more or less than a pixel: without a margin there would
// be slits between them.
inline constexpr float kMargin_px = 0.1f;

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

// The pixel centres within half of a middle, cut at the image's side: [first, end). Of what is no number, none: such is
// less than 0.
ONEMAP_TWIN_BODY void centres_around(float middle, float half, float size, std::int32_t& first, std::int32_t& end) {
  const float low = std::min(std::max(0.0f, middle - half), size);
  const float high = std::min(std::max(0.0f, middle + half), size);
  const auto low_whole = static_cast<std::int32_t>(low), high_whole = static_cast<std::int32_t>(high);
  first = low_whole + (static_cast<float>(low_whole) < low ? 1 : 0);
  end = high_whole + (static_cast<float>(high_whole) < high ? 1 : 0);
}

// Writes all of out.
void find_plain(const Rig& rig, const Row& row, Covered& out);
void find_simd(const Rig& rig, const Row& row, Covered& out);  // where simd_available()

}  // namespace onemap::hal::imaging::footprints
