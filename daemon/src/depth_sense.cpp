#include "daemon/depth_sense.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace onemap::daemon {

namespace {
constexpr int kEach = 8;  // pixels

double mean_of_rgb(const hal::FrameView& frame) {
  const int width = frame.intrinsics->width, height = frame.intrinsics->height;
  std::uint64_t sum = 0, count = 0;
  for (int y = 0; y < height; y += kEach)
    for (int x = 0; x < width; x += kEach, ++count) {
      const auto at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      sum += frame.rgb[at] + frame.rgb[at + 1] + frame.rgb[at + 2];
    }
  return static_cast<double>(sum) / (3 * 255.0 * static_cast<double>(std::max<std::uint64_t>(1, count)));
}

double field_deg(int pixels, double focal) { return 2 * std::atan(pixels / (2 * focal)) * 180 / std::numbers::pi; }
}  // namespace

DepthLook look_at(const hal::FrameView& frame, std::vector<std::uint16_t>& scratch) {
  const hal::Intrinsics& k = *frame.intrinsics;
  scratch.clear();
  std::size_t looked = 0;
  for (int y = 0; y < k.height; y += kEach)
    for (int x = 0; x < k.width; x += kEach, ++looked) {
      const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(x);
      if (frame.depth[at] != 0) scratch.push_back(frame.depth[at]);
    }
  DepthLook look;
  look.brightness = mean_of_rgb(frame);
  look.valid = static_cast<double>(scratch.size()) / static_cast<double>(std::max<std::size_t>(1, looked));
  if (scratch.empty()) return look;
  std::ranges::sort(scratch);
  const auto at = [&](double q) {
    return scratch[static_cast<std::size_t>(q * static_cast<double>(scratch.size() - 1))] / k.depth_scale;
  };
  look.near_m = at(0.05);
  look.median_m = at(0.5);
  look.far_m = at(0.95);
  int step = 0;
  for (std::size_t i = 1; i < scratch.size(); ++i) {
    const int difference = scratch[i] - scratch[i - 1];
    if (difference > 0 && (step == 0 || difference < step)) step = difference;
  }
  look.step_m = step / k.depth_scale;
  return look;
}

std::vector<std::string> doubts(const DepthLook& look) {
  std::vector<std::string> out;
  if (look.brightness < 0.02)
    out.emplace_back("the colour image is black: is the lens covered, or the exposure fixed?");
  if (look.brightness > 0.98) out.emplace_back("the colour image is white: is the exposure fixed?");
  if (look.valid < 0.02) {
    out.emplace_back(
        "there is no depth: is the emitter covered, or all of it nearer or farther than the camera measures?");
    return out;
  }
  if (look.valid < 0.2)
    out.push_back(
        fmt::format("only {:.0f} % of the pixels have depth: sun, glass or black surfaces, or registration fails",
                    100 * look.valid));
  if (look.median_m < 0.2)
    out.push_back(
        fmt::format("half of what is seen is nearer than {:.2f} m: is depth_scale too large (a depth of 1 m must "
                    "be depth_scale)?",
                    look.median_m));
  if (look.median_m > 8)
    out.push_back(
        fmt::format("half of what is seen is farther than {:.1f} m: is depth_scale too small?", look.median_m));
  if (look.step_m == 0 && look.valid > 0.2)
    out.emplace_back("every pixel has the same depth: the camera repeats a constant; look at its mode and its offset");
  return out;
}

std::vector<std::string> doubts(const hal::Intrinsics& k) {
  std::vector<std::string> out;
  const double wide = field_deg(k.width, k.fx);
  if (wide < 30 || wide > 120)
    out.push_back(
        fmt::format("fx = {:.1f} means a field of view of {:.0f} degrees: is it of another image width?", k.fx, wide));
  if (std::abs(k.fx / k.fy - 1) > 0.05)
    out.push_back(
        fmt::format("fx = {:.1f} and fy = {:.1f} differ by {:.0f} %: pixels are square in every camera that is "
                    "known here",
                    k.fx, k.fy, 100 * std::abs(k.fx / k.fy - 1)));
  if (std::abs(k.cx / (k.width - 1) - 0.5) > 0.15 || std::abs(k.cy / (k.height - 1) - 0.5) > 0.15)
    out.push_back(
        fmt::format("the principal point ({:.1f}, {:.1f}) is far from the centre of {} x {}: is it of another "
                    "image size?",
                    k.cx, k.cy, k.width, k.height));
  return out;
}

std::string doubt(const mapping::FocalEstimate& focal) {
  return fmt::format("the focal length is {:.2f} of what fits {} pairs of views (give or take {:.2f}): the map is bent",
                     focal.ratio, focal.views, 2 * focal.sigma);
}

}  // namespace onemap::daemon
