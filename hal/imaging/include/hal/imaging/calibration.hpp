#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"

namespace onemap::hal::imaging {

// The numbers of a calibration by key: fx fy cx cy k1 k2 p1 p2 k3 depth_scale of the lens, noise_least_m
// noise_growth_per_m noise_best_m of depth (hal/depth_noise.hpp), gathered from one or several sources.
// Each is within what any camera can have; whether it suits the images is known when their size is.
class Calibration {
 public:
  static constexpr std::string_view kKnown =
      "fx fy cx cy k1 k2 p1 p2 k3 depth_scale noise_least_m noise_growth_per_m noise_best_m";
  static bool knows(std::string_view key);

  // Sets or replaces; the error carries a reason only: an unknown key, not a number, or one that no camera has. place:
  // where the value stands, for check().
  Status set(std::string_view key, std::string_view value, const std::string& place = {});
  // One `key value` a line, '#' starts a comment. The first unusable or repeated line is the error, with NAME:LINE.
  Status parse(std::string_view text, const std::string& name);
  // The other's keys win.
  void replace_with(const Calibration& other);
  std::vector<std::string> keys() const;
  // Fills what is given in, and needs at least fx fy cx cy; width and height stay. The error names what is missing.
  Status apply(Intrinsics& intrinsics) const;
  bool has_lens() const;  // something that apply() takes
  DepthNoise noise() const;
  // Whether the principal point is in images of this size and the field of view is one of a pinhole camera. The error's
  // place is where the value stands; values without a place (a data set's defaults) are not asked.
  Status check(int width, int height) const;

 private:
  struct Value {
    double number = 0;
    std::string place;
  };
  Status check_within(std::string_view key, double least, double most, const std::string& why) const;
  std::map<std::string, Value, std::less<>> values_;
};

}  // namespace onemap::hal::imaging
