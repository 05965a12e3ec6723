#pragma once
#include <optional>
#include <string>

#include "hal/backends.hpp"
#include "hal/backends/openni2/modes.hpp"
#include "hal/imaging/registration_options.hpp"

namespace onemap::hal::openni2 {

// What an `openni2:` address asks for.
struct Address {
  std::string text;
  std::string uri;  // empty: the first device
  bool file = false;
  std::optional<Mode> mode;
  imaging::RegistrationOptions lenses;
  Duration clock_offset{};
};

// Reads the calibration file that it names.
Result<Address> parse_address(const CameraAddress& address);

}  // namespace onemap::hal::openni2
