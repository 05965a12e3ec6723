#include "address.hpp"

#include <charconv>

namespace onemap::hal::v4l2 {

namespace {

bool whole(std::string_view text, int low, int high, int& value) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size() && value >= low && value <= high;
}

Result<imaging::ImageSize> size_from(const std::string& key, std::string_view text) {
  imaging::ImageSize size;
  const std::size_t by = text.find('x');
  if (by == std::string_view::npos || !whole(text.substr(0, by), 16, 4096, size.width) ||
      !whole(text.substr(by + 1), 16, 4096, size.height))
    return Error{"", key + "=" + std::string(text) + ": expected WIDTHxHEIGHT, each from 16 to 4096"};
  return size;
}

Status set_size(const std::string& key, const std::string& value, std::optional<imaging::ImageSize>& into) {
  const auto size = size_from(key, value);
  if (!size) return size.error();
  into = *size;
  return success();
}

Status set_option(const std::string& key, const std::string& value, V4l2Address& into) {
  if (key == "size") return set_size(key, value, into.size);
  if (key == "depth_size") return set_size(key, value, into.depth_size);
  if (key == "fps" && !whole(value, 1, 120, into.fps))
    return Error{"", "fps=" + value + ": expected a whole number from 1 to 120"};
  if (key == "fps") return success();
  if (key == "registration" && value != "ours" && value != "none")
    return Error{"", "registration=" + value + ": expected ours or none"};
  if (key == "registration") {
    into.as_it_comes = value == "none";
    return success();
  }
  if (key != "color" && key != "calibration")
    return Error{"", "unknown option '" + key + "'; known: color calibration size depth_size fps registration"};
  if (value.empty()) return Error{"", key + " names nothing"};
  (key == "color" ? into.colour_path : into.calibration_file) = value;
  return success();
}

}  // namespace

Result<V4l2Address> parse_v4l2_address(const CameraAddress& address) {
  V4l2Address parsed;
  parsed.text = address.text;
  parsed.depth_path = address.path;
  parsed.clock_offset = address.clock_offset;
  const std::string place = "camera address '" + address.text + "'";
  if (!address.path.empty() && !address.path.starts_with('/'))
    return Error{place, "expected v4l2: or v4l2:/dev/videoN"};
  for (const auto& [key, value] : address.options)
    if (const Status status = set_option(key, value, parsed); !status) return Error{place, status.error().reason};
  return parsed;
}

}  // namespace onemap::hal::v4l2
