#pragma once
// Kinds of keys: how a value of a kind is read from what a file or a command line says, what is said of one that is
// wrong, and how it is written.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "daemon/config_key.hpp"

namespace onemap::daemon::key {

// Three names, so that a row of the table reads as a sentence.
struct About {
  std::string_view section, name;
  std::string text;
};

template <class T>
std::string words(Range<T> range) {
  return fmt::format("{} to {}", range.least, range.most);
}

// As somebody writes it: 0.02, and not what a float makes of it.
template <class T>
ConfigValue written(T value) {
  if constexpr (std::is_integral_v<T>) return static_cast<std::int64_t>(value);
  const std::string text = fmt::format("{}", value);
  double exact = 0;
  std::from_chars(text.data(), text.data() + text.size(), exact);
  return exact;
}

// The value as a T, if it is a number of that kind within the range.
template <class T>
std::optional<T> in_range(const ConfigValue& value, Range<T> range) {
  const auto* whole = std::get_if<std::int64_t>(&value);
  if constexpr (std::is_integral_v<T>) {
    if (!whole || std::cmp_less(*whole, range.least) || std::cmp_greater(*whole, range.most)) return std::nullopt;
    return static_cast<T>(*whole);
  } else {
    const auto* real = std::get_if<double>(&value);
    if (!whole && !real) return std::nullopt;
    const double exact = whole ? static_cast<double>(*whole) : *real;
    if (!(std::abs(exact) < 1e30)) return std::nullopt;  // NaN, and what a float cannot be
    const T narrow = static_cast<T>(exact);
    return range.holds(narrow) ? std::optional(narrow) : std::nullopt;
  }
}

template <class T>
Error refused(const ConfigValue& value, Range<T> range) {
  const bool is_whole = std::holds_alternative<std::int64_t>(value);
  if (std::is_integral_v<T> && !is_whole) return {"", "expected a whole number, " + words(range)};
  if (!is_whole && !std::holds_alternative<double>(value)) return {"", "expected a number, " + words(range)};
  return {"", fmt::format("{} is not within {}", toml_text(value), words(range))};
}

// field(config) is the number that a key sets.
template <class T, class Field>
ConfigKey number(About about, Range<T> range, Field field) {
  const auto set = [range, field](const ConfigValue& value, Config& config) -> Status {
    const auto accepted = in_range(value, range);
    if (!accepted) return refused(value, range);
    field(config) = *accepted;
    return success();
  };
  return {about.section, about.name, std::move(about.text),
          words(range),  set,        [field](const Config& config) { return written(field(config)); }};
}

// Mebibytes in the file, bytes in the field.
template <class Field>
ConfigKey megabytes(About about, Range<std::size_t> bytes, Field field) {
  const Range<std::size_t> range{bytes.least >> 20, bytes.most >> 20};
  const auto set = [range, field](const ConfigValue& value, Config& config) -> Status {
    const auto accepted = in_range(value, range);
    if (!accepted) return refused(value, range);
    field(config) = *accepted << 20;
    return success();
  };
  return {about.section, about.name, std::move(about.text),
          words(range),  set,        [field](const Config& config) { return written(field(config) >> 20); }};
}

// Text that check() accepts; an empty one is as if nothing were said: the default.
inline ConfigKey text(About about, std::string values, std::string Config::*field,
                      Status (*check)(const std::string&)) {
  const auto set = [field, check](const ConfigValue& value, Config& config) -> Status {
    const auto* words = std::get_if<std::string>(&value);
    if (!words) return Error{"", "expected a string"};
    if (auto status = words->empty() ? success() : check(*words); !status) return status;
    config.*field = words->empty() ? Config().*field : *words;
    return success();
  };
  return {about.section,     about.name, std::move(about.text),
          std::move(values), set,        [field](const Config& config) { return config.*field; }};
}

// A list of texts of this form that check() accepts.
inline ConfigKey list(About about, const std::string& form, const std::string& example,
                      std::vector<std::string> Config::*field, Status (*check)(const std::string&)) {
  const auto set = [form, field, check](const ConfigValue& value, Config& config) -> Status {
    const auto* list = std::get_if<std::vector<std::string>>(&value);
    if (!list) return Error{"", "expected a list of \"" + form + "\""};
    for (const std::string& one : *list)
      if (auto status = check(one); !status) return status;
    config.*field = *list;
    return success();
  };
  return {about.section,
          about.name,
          std::move(about.text),
          "a list of " + form + ", " + example,
          set,
          [field](const Config& config) { return config.*field; }};
}

// field(config) is what a key switches.
template <class Field>
ConfigKey yes_or_no(About about, Field field) {
  const auto set = [field](const ConfigValue& value, Config& config) -> Status {
    const auto* said = std::get_if<bool>(&value);
    if (!said) return Error{"", "expected true or false"};
    field(config) = *said;
    return success();
  };
  return {about.section,   about.name, std::move(about.text),
          "true or false", set,        [field](const Config& config) { return field(config); }};
}

// One of two words, each for a value of the field.
template <class T, class Field>
ConfigKey either(About about, std::pair<std::string_view, T> one, std::pair<std::string_view, T> other, Field field) {
  const auto set = [one, other, field](const ConfigValue& value, Config& config) -> Status {
    const auto* word = std::get_if<std::string>(&value);
    if (!word || (*word != one.first && *word != other.first)) {
      const std::string near = word ? near_word(*word, std::array{one.first, other.first}) : "";
      return Error{"", fmt::format("{} is neither {} nor {}{}", toml_text(value), one.first, other.first, near)};
    }
    field(config) = *word == one.first ? one.second : other.second;
    return success();
  };
  const auto get = [one, other, field](const Config& config) -> ConfigValue {
    return std::string(field(config) == one.second ? one.first : other.first);
  };
  return {about.section, about.name, std::move(about.text), fmt::format("\"{}\" or \"{}\"", one.first, other.first),
          set,           get};
}

// A list of some of these words, each once. field(config) is the list.
template <class Field>
ConfigKey some_of(About about, std::vector<std::string_view> words, Field field) {
  std::string known;
  for (const std::string_view word : words) known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", word);
  const auto set = [words = std::move(words), known, field](const ConfigValue& value, Config& config) -> Status {
    const auto* list = std::get_if<std::vector<std::string>>(&value);
    if (!list || list->empty()) return Error{"", "expected a list of " + known};
    for (auto word = list->begin(); word != list->end(); ++word) {
      const bool is_known = std::ranges::find(words, *word) != words.end();
      if (!is_known || std::find(list->begin(), word, *word) != word)
        return Error{"", fmt::format("\"{}\" is not one of {}, each once{}", *word, known,
                                     is_known ? "" : near_word(*word, words))};
    }
    field(config) = *list;
    return success();
  };
  return {about.section,        about.name, std::move(about.text),
          "a list of " + known, set,        [field](const Config& config) { return field(config); }};
}

inline ConfigKey live(ConfigKey key) {
  key.reload = Reload::live;
  return key;
}

}  // namespace onemap::daemon::key
