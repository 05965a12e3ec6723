#pragma once
#include <string>

#include "hal/backends.hpp"
#include "hal/imaging/registration_options.hpp"

namespace onemap::hal::libusb {

// What a `libusb:` address asks for.
struct Address {
  std::string text;
  std::string serial;  // empty: the first
  imaging::RegistrationOptions lenses;
  Duration clock_offset{};
};

// Reads the calibration file that it names.
Result<Address> parse_address(const CameraAddress& address);

}  // namespace onemap::hal::libusb
