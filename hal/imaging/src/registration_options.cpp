#include "hal/imaging/registration_options.hpp"

#include <charconv>

namespace onemap::hal::imaging {

namespace {

Status set_registration(const std::string& value, std::optional<Registration>& into) {
  if (value == "device")
    into = Registration::device;
  else if (value == "ours")
    into = Registration::ours;
  else if (value == "none")
    into = Registration::none;
  else
    return Error{"", "registration=" + value + ": expected device, ours or none"};
  return success();
}

Status set_baseline(const std::string& value, double& into) {
  const auto [end, code] = std::from_chars(value.data(), value.data() + value.size(), into);
  const bool number = code == std::errc{} && end == value.data() + value.size();
  if (number && into >= -0.5 && into <= 0.5) return success();
  return Error{"", "baseline=" + value + ": expected metres from -0.5 to 0.5"};
}

}  // namespace

std::string_view to_string(Registration registration) {
  switch (registration) {
    case Registration::device:
      return "registered by the device";
    case Registration::ours:
      return "registered by us";
    case Registration::none:
      return "taken as registered";
  }
  return "unknown";
}

bool RegistrationOptions::knows(std::string_view key) {
  return key == "registration" || key == "baseline" || key == "calibration" || Calibration::knows(key);
}

Status RegistrationOptions::set(const std::string& key, const std::string& value) {
  if (key == "registration") return set_registration(value, registration);
  if (key == "baseline") return set_baseline(value, baseline_m);
  if (key == "calibration") return success();  // read before
  if (calibration_source.empty()) calibration_source = "options";
  return calibration.set(key, value);
}

Status RegistrationOptions::set_file(const std::string& text, const std::string& name) {
  calibration_source = name;
  return calibration.parse(text, name);
}

Status RegistrationOptions::check() const {
  if (!calibration.has_lens()) return success();
  Intrinsics tried;
  return calibration.apply(tried);
}

}  // namespace onemap::hal::imaging
