#include "address.hpp"

#include "hal/base/file.hpp"

namespace onemap::hal::openni2 {

namespace {

Status set_mode(const std::string& value, Address& into) {
  into.mode = parse_mode(value);
  if (into.mode) return success();
  return Error{"", "mode=" + value + ": expected WIDTHxHEIGHT@FPS, for example 640x480@30"};
}

Status set_option(const std::string& key, const std::string& value, Address& into) {
  if (key == "mode") return set_mode(value, into);
  if (!imaging::RegistrationOptions::knows(key))
    return Error{"", "unknown option '" + key + "'; known: mode " + std::string(imaging::RegistrationOptions::kKnown)};
  if (Status status = into.lenses.set(key, value); !status) return status;
  if (into.file && into.lenses.registration == imaging::Registration::device)
    return Error{"", "registration=device: a recording cannot be registered by its device"};
  return success();
}

}  // namespace

Result<Address> parse_address(const CameraAddress& address) {
  Address parsed;
  parsed.text = address.text;
  parsed.uri = address.path;
  parsed.file = address.path.ends_with(".oni");
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

}  // namespace onemap::hal::openni2
