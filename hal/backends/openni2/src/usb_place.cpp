#include "hal/backends/openni2/usb_place.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

#include "hal/base/file.hpp"

namespace onemap::hal::openni2 {

namespace {

struct Place {
  int bus = 0, device = 0;
  bool operator==(const Place&) const = default;
};

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<Place> place_of(std::string_view uri) {
  const std::size_t at = uri.rfind('@'), slash = uri.rfind('/');
  if (at == std::string_view::npos || slash == std::string_view::npos || slash < at) return std::nullopt;
  const auto bus = whole_number(uri.substr(at + 1, slash - at - 1)), device = whole_number(uri.substr(slash + 1));
  return bus && device ? std::optional(Place{*bus, *device}) : std::nullopt;
}

// The first line of an attribute; empty when there is none.
std::string attribute(const std::filesystem::path& folder, const char* name) {
  const auto text = read_text_file(folder / name, kSmallFileBytes);
  return text ? text->substr(0, text->find('\n')) : "";
}

// In Mbit/s, as sysfs has it; empty when it is not known.
std::string speed_of(const Place& place, const std::string& root) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(root + "/sys/bus/usb/devices", none)) {
    const auto bus = whole_number(attribute(entry.path(), "busnum")),
               device = whole_number(attribute(entry.path(), "devnum"));
    if (bus && device && Place{*bus, *device} == place) return attribute(entry.path(), "speed");
  }
  return {};
}

}  // namespace

std::string usb_problem(std::string_view uri, const std::string& root) {
  const auto place = place_of(uri);
  if (!place) return {};
  const std::string node = fmt::format("/dev/bus/usb/{:03}/{:03}", place->bus, place->device);
  if (access((root + node).c_str(), R_OK | W_OK) != 0) return node + ": " + std::strerror(errno);
  const std::string speed = speed_of(*place, root);
  if (speed != "12" && speed != "1.5") return {};
  return fmt::format("runs at {} Mbit/s; it needs a USB 2 port with 480 Mbit/s", speed);
}

}  // namespace onemap::hal::openni2
