#include "address.hpp"

#include "hal/base/file.hpp"

namespace onemap::hal::libusb {

namespace {

Status set_option(const std::string& key, const std::string& value, Address& into) {
  if (imaging::RegistrationOptions::knows(key)) return into.lenses.set(key, value);
  return Error{"", "unknown option '" + key + "'; known: " + std::string(imaging::RegistrationOptions::kKnown)};
}

}  // namespace

Result<Address> parse_address(const CameraAddress& address) {
  Address parsed;
  parsed.text = address.text;
  parsed.serial = address.path;
  parsed.clock_offset = address.clock_offset;
  const std::string place = "camera address '" + address.text + "'";
  if (const auto file = address.options.find("calibration"); file != address.options.end()) {
    const Result<std::string> text = read_text_file(file->second, kSmallFileBytes);
    if (!text) return text.error();
    if (const Status status = parsed.lenses.set_file(*text, file->second); !status) return status.error();
  }
  for (const auto& [key, value] : address.options)
    if (const Status status = set_option(key, value, parsed); !status) return Error{place, status.error().reason};
  if (const Status status = parsed.lenses.check(); !status) return Error{place, status.error().reason};
  return parsed;
}

}  // namespace onemap::hal::libusb
