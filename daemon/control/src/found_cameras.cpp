#include "control/found_cameras.hpp"

#include <fmt/format.h>

#include "hal/base/text.hpp"

namespace onemap::control {

namespace {

// Libraries of drivers may talk, too: the answer is the line that is an object.
std::string line_with_object(const std::string& text) {
  std::string found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (text[at] == '{') found = text.substr(at, end - at);
    at = end + 1;
  }
  return found;
}

std::string value_at(const Json& camera, const char* key) {
  const auto value = camera.find(key);
  return value != camera.end() && value->is_string() ? printable(value->get<std::string>()) : "";
}

}  // namespace

Result<Json> found_cameras(const Machine& machine) {
  const auto told = machine.onemapd("--cameras --json");
  if (!told) return Error{"onemapd --cameras", "the program onemapd is not found"};
  if (told->status == Told::kTooLong) return Error{"onemapd --cameras", "does not end: a driver hangs"};
  Json answer = Json::parse(line_with_object(told->text), nullptr, false);
  const bool good = answer.is_object() && answer.contains("found") && answer["found"].is_array();
  if (told->status != 0 || !good)
    return Error{"onemapd --cameras", fmt::format("it ends with status {}: {}", told->status, printable(told->text))};
  return answer;
}

std::string found_cameras_words(const Json& found) {
  std::string text;
  for (const Json& camera : found.at("found")) {
    text += fmt::format("{}\n  {}\n", value_at(camera, "address"), value_at(camera, "description"));
    for (const auto& [key, words] :
         {std::pair{"abilities", ""}, {"limits", "limited: "}, {"problem", "cannot be used: "}})
      if (const std::string value = value_at(camera, key); !value.empty())
        text += fmt::format("  {}{}\n", words, value);
  }
  if (text.empty())
    return "no camera found on this machine; recordings and simulations are named, see onemapd --help\n";
  const std::string best = value_at(found, "auto");
  return text + (best.empty() ? "none of them can be used\n" : fmt::format("auto is {}\n", best));
}

}  // namespace onemap::control
