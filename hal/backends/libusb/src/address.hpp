#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hal/backends.hpp"
#include "hal/imaging/calibration.hpp"

namespace onemap::hal::libusb {

enum class Registration : std::uint8_t { device, ours, none };

// What a `libusb:` address asks for.
struct Address {
  std::string text;
  std::string serial;  // empty: the first
  std::optional<Registration> registration;
  double baseline_m = 0.025;
  imaging::Calibration calibration;
  std::string calibration_source = "nominal, 525 px";  // for people
  Duration clock_offset{};
};

// Reads the calibration file that it names.
Result<Address> parse_address(const CameraAddress& address);

}  // namespace onemap::hal::libusb
