#pragma once
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace onemap::daemon {

// Prometheus' text format, version 0.0.4: a family with its help and type, then its samples. Values of labels may hold
// anything; they are escaped.
class PrometheusText {
 public:
  using Labels = std::initializer_list<std::pair<std::string_view, std::string_view>>;
  enum class Type { counter, gauge, summary };

  void family(std::string_view name, Type type, std::string_view help);  // its samples follow
  void sample(Labels labels, double value) { sample("", labels, value); }
  void sample(std::string_view suffix, Labels labels, double value);  // suffix: _sum, _count of a summary
  void one(std::string_view name, Type type, std::string_view help, double value);
  std::string take() { return std::move(text_); }

 private:
  std::string text_, name_;
};

}  // namespace onemap::daemon
