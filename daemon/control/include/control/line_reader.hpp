#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace onemap::control {

// A stream of bytes as lines of a bounded length. Of a line that is longer only that is told, once, as soon as it is
// known; its rest is skipped, and the next line is good again.
class LineReader {
 public:
  struct Line {
    std::string text;  // without its end (\n or \r\n)
    bool too_long = false;
  };
  explicit LineReader(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  void add(std::string_view bytes) { buffer_.append(bytes); }
  bool next(Line& line);                                     // false: none is complete yet
  std::size_t held() const { return buffer_.size() - at_; }  // bytes; at most the longest line after next() said false

 private:
  bool skip();
  void tidy();
  std::size_t most_bytes_;
  std::string buffer_;
  std::size_t at_ = 0;  // of the buffer, not looked at yet
  bool skipping_ = false;
};

}  // namespace onemap::control
