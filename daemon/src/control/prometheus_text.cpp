#include "daemon/control/prometheus_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace onemap::daemon {

namespace {
std::string escaped(std::string_view text, bool quotes) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\\\";
    else if (c == '\n')
      out += "\\n";
    else if (c == '"' && quotes)
      out += "\\\"";
    else
      out += c;
  }
  return out;
}

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return fmt::format("{}", value);
}

constexpr std::string_view name_of(PrometheusText::Type type) {
  switch (type) {
    case PrometheusText::Type::counter:
      return "counter";
    case PrometheusText::Type::gauge:
      return "gauge";
    case PrometheusText::Type::summary:
      return "summary";
  }
  return "untyped";
}
}  // namespace

void PrometheusText::family(std::string_view name, Type type, std::string_view help) {
  name_ = name;
  text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, escaped(help, false), name, name_of(type));
}

void PrometheusText::sample(std::string_view suffix, Labels labels, double value) {
  text_.append(name_).append(suffix);
  if (labels.size() > 0) {
    char before = '{';
    for (const auto& [key, text] : labels) {
      text_ += fmt::format("{}{}=\"{}\"", before, key, escaped(text, true));
      before = ',';
    }
    text_ += '}';
  }
  text_ += ' ' + number(value) + '\n';
}

void PrometheusText::one(std::string_view name, Type type, std::string_view help, double value) {
  family(name, type, help);
  sample({}, value);
}

}  // namespace onemap::daemon
