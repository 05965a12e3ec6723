#include "hal/imaging/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "hal/imaging/image_size.hpp"
#include "hal/imaging/text_lines.hpp"
#include "hal/lens.hpp"

namespace onemap::hal::imaging {

namespace {

constexpr double kMostDistortion = 100;  // dimensionless; real lenses have less than 10

struct Key {
  std::string_view name;
  double Intrinsics::*field;
  bool needed;
  double least, most;
  double DepthNoise::*noise = nullptr;  // instead of field
};
constexpr Key noise_key(std::string_view name, double DepthNoise::*field, const Range<double>& range) {
  return {name, nullptr, false, range.least, range.most, field};
}
constexpr double kLeastFocal = 1, kMostFocal = kFocalLengthWidths.most * kMostSide_px;
constexpr Key kKeys[] = {
    {"fx", &Intrinsics::fx, true, kLeastFocal, kMostFocal},
    {"fy", &Intrinsics::fy, true, kLeastFocal, kMostFocal},
    {"cx", &Intrinsics::cx, true, -0.5, kMostSide_px},
    {"cy", &Intrinsics::cy, true, -0.5, kMostSide_px},
    {"k1", &Intrinsics::k1, false, -kMostDistortion, kMostDistortion},
    {"k2", &Intrinsics::k2, false, -kMostDistortion, kMostDistortion},
    {"p1", &Intrinsics::p1, false, -kMostDistortion, kMostDistortion},
    {"p2", &Intrinsics::p2, false, -kMostDistortion, kMostDistortion},
    {"k3", &Intrinsics::k3, false, -kMostDistortion, kMostDistortion},
    {"depth_scale", &Intrinsics::depth_scale, false, kDepthScale.least, kDepthScale.most},
    noise_key("noise_least_m", &DepthNoise::least_m, kLeastNoise_m),
    noise_key("noise_growth_per_m", &DepthNoise::growth_per_m, kNoiseGrowth_per_m),
    noise_key("noise_best_m", &DepthNoise::best_m, kBestDistance_m),
};

const Key* find(std::string_view name) {
  const auto* key = std::find_if(std::begin(kKeys), std::end(kKeys), [&](const Key& k) { return k.name == name; });
  return key == std::end(kKeys) ? nullptr : key;
}

}  // namespace

bool Calibration::knows(std::string_view key) { return find(key) != nullptr; }

Status Calibration::set(std::string_view name, std::string_view text, const std::string& place) {
  const Key* key = find(name);
  if (!key) return Error{"", fmt::format("unknown key '{}'; known: {}", name, kKnown)};
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool number = code == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
  if (!number) return Error{"", fmt::format("{}: '{}' is not a number", name, text)};
  if (value < key->least || value > key->most)
    return Error{"", fmt::format("{}: {} is not within {} to {}", name, text, key->least, key->most)};
  values_.insert_or_assign(std::string(name), Value{value, place});
  return success();
}

Status Calibration::parse(std::string_view text, const std::string& name) {
  Status status = success();
  std::map<std::string, int, std::less<>> seen;  // key, line
  for_each_line(text, [&](int number, const std::vector<std::string_view>& words) {
    if (!status) return;
    const std::string place = fmt::format("{}:{}", name, number);
    if (words.size() != 2) {
      status = Error{place, fmt::format("{} words where 2 (key value) are expected", words.size())};
      return;
    }
    const auto [earlier, is_new] = seen.emplace(words[0], number);
    if (!is_new) {
      status = Error{place, fmt::format("{} was given in line {}", earlier->first, earlier->second)};
    } else if (const Status one = set(words[0], words[1], place); !one) {
      status = Error{place, one.error().reason};
    }
  });
  return status;
}

void Calibration::replace_with(const Calibration& other) {
  for (const auto& [key, value] : other.values_) values_.insert_or_assign(key, value);
}

std::vector<std::string> Calibration::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : values_) keys.push_back(key);
  return keys;
}

Status Calibration::apply(Intrinsics& intrinsics) const {
  std::string missing;
  for (const Key& key : kKeys) {
    const auto found = values_.find(key.name);
    if (!key.field) continue;
    if (found != values_.end()) {
      intrinsics.*key.field = found->second.number;
    } else if (key.needed) {
      missing += fmt::format("{}{}", missing.empty() ? "" : " ", key.name);
    }
  }
  if (!missing.empty()) return Error{"", "the calibration lacks " + missing};
  return success();
}

bool Calibration::has_lens() const {
  return std::ranges::any_of(values_, [](const auto& value) { return find(value.first)->field != nullptr; });
}

DepthNoise Calibration::noise() const {
  DepthNoise noise;
  for (const Key& key : kKeys)
    if (const auto found = values_.find(key.name); key.noise && found != values_.end())
      noise.*key.noise = found->second.number;
  return noise;
}

Status Calibration::check_within(std::string_view key, double least, double most, const std::string& why) const {
  const auto found = values_.find(key);
  if (found == values_.end() || found->second.place.empty()) return success();
  const auto& [number, place] = found->second;
  if (number >= least && number <= most) return success();
  return Error{place, fmt::format("{}: {} is not within {} to {}{}", key, number, least, most, why)};
}

Status Calibration::check(int width, int height) const {
  const std::string why = fmt::format(", for images of {}x{}", width, height);
  const double least = kFocalLengthWidths.least * width, most = kFocalLengthWidths.most * width;
  for (const Status& status : {check_within("fx", least, most, why), check_within("fy", least, most, why),
                               check_within("cx", -0.5, width - 0.5, why), check_within("cy", -0.5, height - 0.5, why)})
    if (!status) return status.error();
  return success();
}

}  // namespace onemap::hal::imaging
