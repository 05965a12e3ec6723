#include "hal/imaging/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "hal/imaging/text_lines.hpp"

namespace onemap::hal::imaging {

namespace {

struct Key {
  std::string_view name;
  double Intrinsics::*field;
  bool needed, positive;
};
constexpr Key kKeys[] = {
    {"fx", &Intrinsics::fx, true, true},   {"fy", &Intrinsics::fy, true, true},
    {"cx", &Intrinsics::cx, true, false},  {"cy", &Intrinsics::cy, true, false},
    {"k1", &Intrinsics::k1, false, false}, {"k2", &Intrinsics::k2, false, false},
    {"p1", &Intrinsics::p1, false, false}, {"p2", &Intrinsics::p2, false, false},
    {"k3", &Intrinsics::k3, false, false}, {"depth_scale", &Intrinsics::depth_scale, false, true},
};

const Key* find(std::string_view name) {
  const auto* key = std::find_if(std::begin(kKeys), std::end(kKeys), [&](const Key& k) { return k.name == name; });
  return key == std::end(kKeys) ? nullptr : key;
}

}  // namespace

bool Calibration::knows(std::string_view key) { return find(key) != nullptr; }

Status Calibration::set(std::string_view name, std::string_view text) {
  const Key* key = find(name);
  if (!key) return Error{"", fmt::format("unknown key '{}'; known: fx fy cx cy k1 k2 p1 p2 k3 depth_scale", name)};
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool number = code == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
  if (!number) return Error{"", fmt::format("{}: '{}' is not a number", name, text)};
  if (key->positive && value <= 0) return Error{"", fmt::format("{} must be positive", name)};
  values_.insert_or_assign(std::string(name), value);
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
    } else if (const Status one = set(words[0], words[1]); !one) {
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
    if (found != values_.end()) {
      intrinsics.*key.field = found->second;
    } else if (key.needed) {
      missing += fmt::format("{}{}", missing.empty() ? "" : " ", key.name);
    }
  }
  if (!missing.empty()) return Error{"", "the calibration lacks " + missing};
  return success();
}

}  // namespace onemap::hal::imaging
