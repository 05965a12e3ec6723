#include "control/wrapped.hpp"

#include <algorithm>

namespace onemap::control {

namespace {

// Where the lines that go on a line begin.
std::size_t indent_of(std::string_view line, std::size_t columns) {
  const std::size_t start = std::min(line.find_first_not_of(' '), line.size());
  const std::size_t gap = line.find("  ", start);
  const std::size_t said = gap == std::string_view::npos ? gap : line.find_first_not_of(' ', gap);
  return said < columns / 2 ? said : start;
}

void put_line(std::string_view line, std::size_t columns, std::string& out) {
  const std::size_t indent = indent_of(line, columns);
  std::size_t blanks = 0;  // of the indent that is there instead of text
  while (blanks + line.size() > columns) {
    const std::size_t room = columns - blanks, first = line.find_first_not_of(' ', blanks == 0 ? indent : 0);
    std::size_t cut = line.rfind(' ', room);
    if (cut == std::string_view::npos || cut <= first) cut = line.find(' ', std::max(room, first));
    if (cut == std::string_view::npos) break;  // one word
    out.append(line.substr(0, cut)).append("\n").append(indent, ' ');
    line.remove_prefix(std::min(line.find_first_not_of(' ', cut), line.size()));
    blanks = indent;
  }
  out.append(line);
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t columns) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    put_line(text.substr(0, end), columns, out);
    if (end == text.size()) break;
    out += '\n';
    text.remove_prefix(end + 1);
  }
  return out;
}

}  // namespace onemap::control
