#include "address.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "hal/base/file.hpp"

namespace onemap::hal::libusb {

namespace {

Status set_registration(const std::string& value, Address& into) {
  constexpr std::array<std::pair<std::string_view, Registration>, 3> kNames{
      {{"device", Registration::device}, {"ours", Registration::ours}, {"none", Registration::none}}};
  for (const auto& [name, registration] : kNames)
    if (name == value) into.registration = registration;
  if (!into.registration) return Error{"", "registration=" + value + ": expected device, ours or none"};
  return success();
}

Status set_baseline(const std::string& value, Address& into) {
  const auto [end, code] = std::from_chars(value.data(), value.data() + value.size(), into.baseline_m);
  const bool number = code == std::errc{} && end == value.data() + value.size();
  if (!number || !(into.baseline_m >= -0.5 && into.baseline_m <= 0.5))
    return Error{"", "baseline=" + value + ": expected metres from -0.5 to 0.5"};
  return success();
}

Status set_option(const std::string& key, const std::string& value, Address& into) {
  if (key == "calibration") return success();
  if (imaging::Calibration::knows(key)) return into.calibration.set(key, value);
  if (key == "registration") return set_registration(value, into);
  if (key == "baseline") return set_baseline(value, into);
  return Error{"", "unknown option '" + key +
                       "'; known: registration baseline calibration fx fy cx cy k1 k2 p1 p2 k3 " + "depth_scale"};
}

}  // namespace

Result<Address> parse_address(const CameraAddress& address) {
  Address parsed;
  parsed.text = address.text;
  parsed.serial = address.path;
  parsed.clock_offset = address.clock_offset;
  const std::string place = "camera address '" + address.text + "'";
  const auto file = address.options.find("calibration");
  if (file != address.options.end()) {
    const Result<std::string> text = read_text_file(file->second, kSmallFileBytes);
    if (!text) return text.error();
    if (const Status status = parsed.calibration.parse(*text, file->second); !status) return status.error();
  }
  for (const auto& [key, value] : address.options)
    if (const Status status = set_option(key, value, parsed); !status) return Error{place, status.error().reason};
  if (parsed.calibration.keys().empty()) return parsed;
  parsed.calibration_source = file == address.options.end() ? "options" : file->second;
  Intrinsics tried;
  if (const Status status = parsed.calibration.apply(tried); !status) return Error{place, status.error().reason};
  return parsed;
}

}  // namespace onemap::hal::libusb
