#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hal/backends.hpp"
#include "hal/backends/openni2/modes.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::openni2 {

enum class Registration : std::uint8_t { device, ours, none };

// What an `openni2:` address asks for.
struct Address {
  std::string text;
  std::string uri;  // empty: the first device
  bool file = false;
  std::optional<Mode> mode;
  std::optional<Registration> registration;
  double baseline_m = 0.025;  // PrimeSense's
  imaging::Calibration calibration;
  std::string calibration_source;  // for people; empty: the device's field of view
  Duration clock_offset{};
};

// Reads the calibration file that it names.
Result<Address> parse_address(const CameraAddress& address);

}  // namespace onemap::hal::openni2
