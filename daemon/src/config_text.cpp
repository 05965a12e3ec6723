#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "daemon/config_key.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + "\"";
}

struct TomlText {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
  std::string operator()(double value) const { return fmt::format("{}", value); }
  std::string operator()(const std::string& value) const { return quoted(value); }
  std::string operator()(const std::vector<std::string>& values) const {
    std::string text;
    for (const std::string& value : values) text += (text.empty() ? "" : ", ") + quoted(value);
    return "[" + text + "]";
  }
};

// Letters to insert, remove, replace, or swap with their neighbour, until one word is the other.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j] + (a[i] == b[j] ? 0 : 1), row[j] + 1, last[j + 1] + 1});
      const bool swapped = i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j];
      if (swapped) row[j + 1] = std::min(row[j + 1], before[j - 1] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last.back();
}

// A slip of the pen, and not another word.
bool is_slip(std::size_t distance, std::string_view word) { return distance <= 1 + word.size() / 4; }

}  // namespace

std::string unknown_key(std::string_view section, std::string_view name) {
  const ConfigKey* nearest = nullptr;
  std::size_t best = 0;
  std::string known;
  for (const ConfigKey& key : config_keys()) {
    if (key.section == section) known += (known.empty() ? "" : ", ") + std::string(key.name);
    // A key of this section before an equally near one of another.
    const std::size_t d = 2 * distance(name, key.name) + (key.section == section ? 0 : 1);
    if (!nearest || d < best) nearest = &key, best = d;
  }
  std::string text = fmt::format("unknown key '{}' in [{}]", name, section);
  if (is_slip(best / 2, name))
    text += fmt::format("; did you mean '{}'{}?", nearest->name,
                        nearest->section == section ? "" : fmt::format(" in [{}]", nearest->section));
  return text + "; known here: " + known;
}

std::string unknown_section(std::string_view name) {
  std::string nearest, known;
  for (const ConfigSection& section : config_sections()) {
    known += (known.empty() ? "" : ", ") + std::string(section.name);
    if (is_slip(distance(name, section.name), name)) nearest = section.name;
  }
  const std::string hint = nearest.empty() ? "" : fmt::format("; did you mean [{}]?", nearest);
  return fmt::format("unknown section '{}'{}; known: {}", name, hint, known);
}

std::string near_word(std::string_view word, std::span<const std::string_view> words) {
  std::string_view nearest;
  std::size_t best = 0;
  for (const std::string_view known : words) {
    const std::size_t d = distance(word, known);
    if (nearest.empty() || d < best) nearest = known, best = d;
  }
  return nearest.empty() || !is_slip(best, word) ? "" : fmt::format("; did you mean \"{}\"?", nearest);
}

std::string toml_text(const ConfigValue& value) { return std::visit(TomlText{}, value); }

std::string config_text(const Config& config) {
  std::string text =
      "# The configuration of onemapd, in TOML: every key, with its default. What a file leaves out has its default;\n"
      "# FILE.d/*.toml go over FILE in the order of their names, and the command line goes over all of them.\n";
  for (const ConfigSection& section : config_sections()) {
    text += fmt::format("\n# {}\n[{}]\n", section.text, section.name);
    for (const ConfigKey& key : config_keys())
      if (key.section == section.name)
        text += fmt::format("# {}\n#   {}\n{} = {}\n", key.text, key.values, key.name, toml_text(key.get(config)));
  }
  return text;
}

std::string origins_text(const Config& config) {
  std::string text;
  for (const ConfigSection& section : config_sections()) {
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section.name);
    for (const ConfigKey& key : config_keys()) {
      if (key.section != section.name) continue;
      const auto origin = config.origins.find(key.full_name());
      text += fmt::format("{} = {}  # from {}\n", key.name, toml_text(key.get(config)),
                          origin == config.origins.end() ? "default" : printable(origin->second));
    }
  }
  return text;
}

}  // namespace onemap::daemon
