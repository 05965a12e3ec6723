#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/base/result.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::imaging {

// Who moves depth onto the colour image: the device, we, or nobody (it is taken as it comes).
enum class Registration : std::uint8_t { device, ours, none };
std::string_view to_string(Registration registration);  // "registered by us"

// What the address of a camera with a colour and a depth lens beside each other can say of them.
struct RegistrationOptions {
  static constexpr std::string_view kKnown =
      "registration baseline calibration fx fy cx cy k1 k2 p1 p2 k3 depth_scale noise_least_m noise_growth_per_m "
      "noise_best_m";

  std::optional<Registration> registration;
  double baseline_m = 0.025;  // from the depth lens to colour's; PrimeSense's
  Calibration calibration;
  std::string calibration_source;  // for people: the file or "options"; empty: none was given

  static bool knows(std::string_view key);
  // registration=, baseline= and the calibration's keys, each with a reason why not; calibration=FILE is for whoever
  // reads files.
  Status set(const std::string& key, const std::string& value);
  // The text of that file, before any key of the calibration is set: those win.
  Status set_file(const std::string& text, const std::string& name);
  // Whether the calibration is a whole one, or none was given.
  Status check() const;
};

}  // namespace onemap::hal::imaging
