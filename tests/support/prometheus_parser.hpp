#pragma once
// A strict reader of Prometheus' text format 0.0.4: throws at whatever a server would stumble over.
#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace onemap::test {

struct PrometheusFamily {
  std::string type, help;
  std::map<std::string, double> samples;  // by name and labels as they stand, unescaped
};

class PrometheusParser {
 public:
  static std::map<std::string, PrometheusFamily> parse(const std::string& text) { return PrometheusParser(text).run(); }

 private:
  explicit PrometheusParser(const std::string& text) : text_(text) {}

  std::map<std::string, PrometheusFamily> run() {
    if (!text_.empty() && text_.back() != '\n') fail("no end of the last line");
    while (at_ < text_.size()) {
      if (text_[at_] == '#')
        comment();
      else
        sample();
    }
    for (const auto& [name, family] : families_)
      if (family.type.empty() || family.help.empty()) fail(name + " has no type or no help");
    return families_;
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw std::runtime_error(fmt::format("{} near '{}'", why, text_.substr(at_ > 20 ? at_ - 20 : 0, 60)));
  }
  void expect(const std::string& what) {
    if (text_.compare(at_, what.size(), what) != 0) fail("expected '" + what + "'");
    at_ += what.size();
  }
  std::string name(bool colons) {
    const std::size_t begin = at_;
    while (at_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_' || (colons && text_[at_] == ':')))
      ++at_;
    if (begin == at_ || std::isdigit(static_cast<unsigned char>(text_[begin]))) fail("expected a name");
    return text_.substr(begin, at_ - begin);
  }
  std::string rest() {
    const std::size_t end = text_.find('\n', at_);
    const std::string line = text_.substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }
  void comment() {
    expect("# ");
    const bool is_help = text_.compare(at_, 5, "HELP ") == 0;
    expect(is_help ? "HELP " : "TYPE ");
    const std::string family = name(true);
    expect(" ");
    const std::string words = rest();
    if (words.empty()) fail("empty");
    if (is_help) {
      if (!families_.emplace(family, PrometheusFamily{"", words, {}}).second) fail(family + " comes twice");
      current_ = family;
      return;
    }
    if (family != current_) fail("TYPE of another family than HELP");
    if (words != "counter" && words != "gauge" && words != "summary") fail("type " + words);
    if (!families_[family].type.empty()) fail("two types");
    families_[family].type = words;
  }
  std::string value_text() {
    std::string value;
    expect("\"");
    for (;; ++at_) {
      if (at_ >= text_.size() || text_[at_] == '\n') fail("a label's value does not end");
      if (text_[at_] == '"') break;
      if (text_[at_] == '\\') {
        ++at_;
        if (text_[at_] != '\\' && text_[at_] != '"' && text_[at_] != 'n') fail("unknown escape");
        value += text_[at_] == 'n' ? '\n' : text_[at_];
      } else {
        value += text_[at_];
      }
    }
    ++at_;
    return value;
  }
  std::string labels() {
    std::set<std::string> seen;
    std::string out;
    if (text_[at_] != '{') return out;
    do {
      ++at_;
      const std::string label = name(false);
      if (!seen.insert(label).second) fail("label twice");
      expect("=");
      out += fmt::format("{}{}={}", out.empty() ? "" : ",", label, value_text());
    } while (at_ < text_.size() && text_[at_] == ',');
    expect("}");
    return "{" + out + "}";
  }
  double number() {
    const std::string word = rest();
    if (word == "NaN") return std::nan("");
    if (word == "+Inf" || word == "-Inf") return word[0] == '+' ? HUGE_VAL : -HUGE_VAL;
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) fail("no number: " + word);
    return value;
  }
  void sample() {
    const std::string sample_name = name(true);
    PrometheusFamily& family = families_[current_];
    const bool summary =
        family.type == "summary" && (sample_name == current_ + "_sum" || sample_name == current_ + "_count");
    if (sample_name != current_ && !summary) fail(sample_name + " stands in the family " + current_);
    if (family.type == "counter" && !current_.ends_with("_total")) fail("a counter that does not end in _total");
    const std::string key = sample_name + labels();
    expect(" ");
    const double value = number();
    if (family.type == "counter" && !(value >= 0)) fail("a negative counter");
    if (!family.samples.emplace(key, value).second) fail(key + " comes twice");
  }

  const std::string& text_;
  std::size_t at_ = 0;
  std::string current_;
  std::map<std::string, PrometheusFamily> families_;
};

}  // namespace onemap::test
