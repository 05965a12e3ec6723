#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/frame.hpp"

namespace onemap::hal::imaging {

// The numbers of a calibration by key: fx fy cx cy k1 k2 p1 p2 k3 depth_scale, gathered from one or several sources.
class Calibration {
 public:
  static bool knows(std::string_view key);

  // Sets or replaces; the error carries a reason only: an unknown key, or not a usable number for it.
  Status set(std::string_view key, std::string_view value);
  // One `key value` a line, '#' starts a comment. The first unusable or repeated line is the error, with NAME:LINE.
  Status parse(std::string_view text, const std::string& name);
  // The other's keys win.
  void replace_with(const Calibration& other);
  std::vector<std::string> keys() const;
  // Fills what is given in, and needs at least fx fy cx cy; width and height stay. The error names what is missing.
  Status apply(Intrinsics& intrinsics) const;

 private:
  std::map<std::string, double, std::less<>> values_;
};

}  // namespace onemap::hal::imaging
