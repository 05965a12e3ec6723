#include "hal/imaging/rig_calibration.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "hal/imaging/text_lines.hpp"
#include "hal/lens.hpp"

namespace onemap::hal::imaging {

namespace {

// What a key's number must be.
enum class Kind { any, positive, side, depth_value };

constexpr Range<double> kAnyNumber{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
constexpr Range<double> kDistortion{-100, 100};  // dimensionless; real lenses have less than 10

struct Key {
  std::string_view name;
  Kind kind;
  Range<double> range = kAnyNumber;
};
constexpr Key kKeys[] = {{"width", Kind::side},
                         {"height", Kind::side},
                         {"fx", Kind::positive},
                         {"fy", Kind::positive},
                         {"cx", Kind::any},
                         {"cy", Kind::any},
                         {"k1", Kind::any, kDistortion},
                         {"k2", Kind::any, kDistortion},
                         {"p1", Kind::any, kDistortion},
                         {"p2", Kind::any, kDistortion},
                         {"k3", Kind::any, kDistortion},
                         {"depth_scale", Kind::positive, kDepthScale},
                         {"depth_none", Kind::depth_value},
                         {"depth_offset_m", Kind::any},
                         {"depth_width", Kind::side},
                         {"depth_height", Kind::side},
                         {"depth_fx", Kind::positive},
                         {"depth_fy", Kind::positive},
                         {"depth_cx", Kind::any},
                         {"depth_cy", Kind::any},
                         {"depth_k1", Kind::any, kDistortion},
                         {"depth_k2", Kind::any, kDistortion},
                         {"depth_p1", Kind::any, kDistortion},
                         {"depth_p2", Kind::any, kDistortion},
                         {"depth_k3", Kind::any, kDistortion},
                         {"colour_from_depth_x", Kind::any},
                         {"colour_from_depth_y", Kind::any},
                         {"colour_from_depth_z", Kind::any},
                         {"colour_from_depth_qx", Kind::any},
                         {"colour_from_depth_qy", Kind::any},
                         {"colour_from_depth_qz", Kind::any},
                         {"colour_from_depth_qw", Kind::any},
                         {"noise_least_m", Kind::any, kLeastNoise_m},
                         {"noise_growth_per_m", Kind::any, kNoiseGrowth_per_m},
                         {"noise_best_m", Kind::any, kBestDistance_m}};
constexpr double kLeastCosine = 0.8660254;  // 30 degrees
constexpr double kMostOffset_m = 0.5;

struct Given {
  double value = 0;
  int line = 0;
};
using Numbers = std::map<std::string, Given, std::less<>>;

Status check_number(const Key& key, double value) {
  const bool whole = value == std::floor(value);
  if (key.kind == Kind::positive && !(value > 0)) return Error{"", fmt::format("{} must be positive", key.name)};
  if (key.kind == Kind::side && !(whole && value >= 1 && value <= kMostSide_px))
    return Error{"", fmt::format("{} must be a whole number from 1 to {}", key.name, kMostSide_px)};
  if (key.kind == Kind::depth_value && !(whole && value >= 0 && value <= 65535))
    return Error{"", fmt::format("{} must be a whole number from 0 to 65535", key.name)};
  if (!key.range.holds(value))
    return Error{"", fmt::format("{} must be within {} to {}", key.name, key.range.least, key.range.most)};
  return success();
}

Status read_line(const std::vector<std::string_view>& words, int line, Numbers& numbers) {
  if (words.size() != 2) return Error{"", fmt::format("{} words where 2 (key value) are expected", words.size())};
  const std::string_view name = words[0], text = words[1];
  const Key* key = nullptr;
  for (const Key& known : kKeys)
    if (known.name == name) key = &known;
  if (!key) return Error{"", fmt::format("unknown key '{}'", name)};
  Given given{0, line};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), given.value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(given.value))
    return Error{"", fmt::format("{}: '{}' is not a number", name, text)};
  if (Status status = check_number(*key, given.value); !status) return status;
  const auto [earlier, is_new] = numbers.emplace(name, given);
  if (!is_new) return Error{"", fmt::format("{} was given in line {}", name, earlier->second.line)};
  return success();
}

Result<Numbers> read_numbers(std::string_view text, const std::string& name) {
  Numbers numbers;
  Status status = success();
  for_each_line(text, [&](int number, const std::vector<std::string_view>& words) {
    if (!status) return;
    if (const Status line = read_line(words, number, numbers); !line)
      status = Error{fmt::format("{}:{}", name, number), line.error().reason};
  });
  if (!status) return status.error();
  return numbers;
}

double value_of(const Numbers& numbers, const std::string& key, double otherwise) {
  const auto found = numbers.find(key);
  return found == numbers.end() ? otherwise : found->second.value;
}

Intrinsics lens_of(const Numbers& numbers, const std::string& prefix) {
  const auto get = [&](const char* key) { return value_of(numbers, prefix + key, 0); };
  Intrinsics k;
  k.width = static_cast<int>(get("width"));
  k.height = static_cast<int>(get("height"));
  k.fx = get("fx"), k.fy = get("fy"), k.cx = get("cx"), k.cy = get("cy");
  k.k1 = get("k1"), k.k2 = get("k2"), k.p1 = get("p1"), k.p2 = get("p2"), k.k3 = get("k3");
  k.depth_scale = value_of(numbers, "depth_scale", 0);
  return k;
}

std::string missing(const Numbers& numbers, const std::string& prefix) {
  std::string names;
  for (const char* key : {"width", "height", "fx", "fy", "cx", "cy"})
    if (!numbers.contains(prefix + key)) names += fmt::format(" {}{}", prefix, key);
  return names;
}

// A lens that no camera has would take registration out of the numbers that it counts with.
Status check_lens(const Numbers& numbers, const std::string& prefix, const std::string& name) {
  const auto get = [&](const std::string& key) { return numbers.find(prefix + key)->second; };
  for (const auto& [along, focal, centre] : {std::tuple("width", "fx", "cx"), {"height", "fy", "cy"}}) {
    const double width = get("width").value, side = get(along).value;
    const Range<double> focal_px{kFocalLengthWidths.least * width, kFocalLengthWidths.most * width};
    for (const auto& [key, range] : {std::pair(focal, focal_px), {centre, Range<double>{-0.5, side - 0.5}}})
      if (const Given given = get(key); !range.holds(given.value))
        return Error{fmt::format("{}:{}", name, given.line),
                     fmt::format("{}{}: {:g} is not within {:g} to {:g}, for images of {:g}x{:g}", prefix, key,
                                 given.value, range.least, range.most, width, get("height").value)};
  }
  return success();
}

bool any_with(const Numbers& numbers, std::initializer_list<std::string_view> prefixes) {
  for (const auto& [key, given] : numbers)
    for (const std::string_view prefix : prefixes)
      if (key.starts_with(prefix) && key != "depth_scale" && key != "depth_none" && key != "depth_offset_m")
        return true;
  return false;
}

Result<ColourFromDepth> pose_of(const Numbers& numbers) {
  const auto get = [&](const char* key, double otherwise) {
    return value_of(numbers, std::string("colour_from_depth_") + key, otherwise);
  };
  const double x = get("qx", 0), y = get("qy", 0), z = get("qz", 0), w = get("qw", 1);
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (std::abs(norm - 1) > 0.01) return Error{"", fmt::format("the quaternion's length is {:.4f}, not 1", norm)};
  const double s = 2 / (norm * norm);
  ColourFromDepth pose;
  pose.rotation = {1 - s * (y * y + z * z), s * (x * y - z * w),     s * (x * z + y * w),
                   s * (x * y + z * w),     1 - s * (x * x + z * z), s * (y * z - x * w),
                   s * (x * z - y * w),     s * (y * z + x * w),     1 - s * (x * x + y * y)};
  const double cosine = (pose.rotation[0] + pose.rotation[4] + pose.rotation[8] - 1) / 2;
  if (cosine < kLeastCosine) return Error{"", "the two lenses look more than 30 degrees apart"};
  pose.translation_m = {get("x", 0), get("y", 0), get("z", 0)};
  for (const double t : pose.translation_m)
    if (std::abs(t) > 1) return Error{"", "the two lenses are more than a metre apart (the unit is metres)"};
  return pose;
}

}  // namespace

Result<RigCalibration> parse_rig_calibration(std::string_view text, const std::string& name) {
  const Result<Numbers> numbers = read_numbers(text, name);
  if (!numbers) return numbers.error();
  const bool two_lenses = any_with(*numbers, {"depth_", "colour_from_depth_"});
  std::string absent = missing(*numbers, "");
  if (two_lenses) absent += missing(*numbers, "depth_");
  if (!numbers->contains("depth_scale")) absent += " depth_scale";
  if (!absent.empty()) return Error{name, "the calibration lacks" + absent};
  for (const std::string prefix : {"", "depth_"})
    if (const Status status = prefix.empty() || two_lenses ? check_lens(*numbers, prefix, name) : success(); !status)
      return status.error();
  RigCalibration rig;
  rig.colour = lens_of(*numbers, "");
  if (two_lenses) rig.depth = lens_of(*numbers, "depth_");
  const Result<ColourFromDepth> pose = pose_of(*numbers);
  if (!pose) return Error{name, pose.error().reason};
  rig.pose = *pose;
  rig.depth_none = static_cast<std::uint16_t>(value_of(*numbers, "depth_none", 0));
  rig.depth_offset_m = value_of(*numbers, "depth_offset_m", 0);
  if (rig.depth_offset_m != 0 && !two_lenses)
    return Error{name, "depth_offset_m needs the depth lens: depth that the device registers stays as it is"};
  if (std::abs(rig.depth_offset_m) > kMostOffset_m)
    return Error{name, fmt::format("depth_offset_m must be within {} m of 0", kMostOffset_m)};
  rig.noise.least_m = value_of(*numbers, "noise_least_m", rig.noise.least_m);
  rig.noise.growth_per_m = value_of(*numbers, "noise_growth_per_m", rig.noise.growth_per_m);
  rig.noise.best_m = value_of(*numbers, "noise_best_m", rig.noise.best_m);
  return rig;
}

std::string text_of(const RigCalibration& rig) {
  std::string out;
  const auto put = [&](std::string_view key, double value) { out += fmt::format("{} {:.9g}\n", key, value); };
  const auto lens = [&](const std::string& prefix, const Intrinsics& k) {
    put(prefix + "width", k.width), put(prefix + "height", k.height);
    put(prefix + "fx", k.fx), put(prefix + "fy", k.fy), put(prefix + "cx", k.cx), put(prefix + "cy", k.cy);
    put(prefix + "k1", k.k1), put(prefix + "k2", k.k2), put(prefix + "p1", k.p1), put(prefix + "p2", k.p2);
    put(prefix + "k3", k.k3);
  };
  lens("", rig.colour);
  put("depth_scale", rig.colour.depth_scale);
  put("depth_none", rig.depth_none);
  if (rig.depth) {
    lens("depth_", *rig.depth);
    put("depth_offset_m", rig.depth_offset_m);
    const auto& r = rig.pose.rotation;  // no more than 30 degrees: qw is the largest
    const double w = std::sqrt(1 + r[0] + r[4] + r[8]) / 2;
    put("colour_from_depth_x", rig.pose.translation_m[0]);
    put("colour_from_depth_y", rig.pose.translation_m[1]);
    put("colour_from_depth_z", rig.pose.translation_m[2]);
    put("colour_from_depth_qx", (r[7] - r[5]) / (4 * w));
    put("colour_from_depth_qy", (r[2] - r[6]) / (4 * w));
    put("colour_from_depth_qz", (r[3] - r[1]) / (4 * w));
    put("colour_from_depth_qw", w);
  }
  put("noise_least_m", rig.noise.least_m);
  put("noise_growth_per_m", rig.noise.growth_per_m);
  put("noise_best_m", rig.noise.best_m);
  return out;
}

Result<Intrinsics> scaled_to(const Intrinsics& k, ImageSize size) {
  if (std::int64_t{k.width} * size.height != std::int64_t{k.height} * size.width)
    return Error{"", fmt::format("the calibration is for {}x{}, and {}x{} has another shape", k.width, k.height,
                                 size.width, size.height)};
  const double s = static_cast<double>(size.width) / k.width;
  Intrinsics out = k;
  out.width = size.width;
  out.height = size.height;
  out.fx *= s;
  out.fy *= s;
  out.cx = s * (k.cx + 0.5) - 0.5;  // pixel centres are at integers
  out.cy = s * (k.cy + 0.5) - 0.5;
  return out;
}

}  // namespace onemap::hal::imaging
