#include "control/line_reader.hpp"

namespace onemap::control {

// True: the line that was too long is over.
bool LineReader::skip() {
  const std::size_t end = buffer_.find('\n', at_);
  at_ = end == std::string::npos ? buffer_.size() : end + 1;
  skipping_ = end == std::string::npos;
  return !skipping_;
}

void LineReader::tidy() {
  buffer_.erase(0, at_);
  at_ = 0;
}

bool LineReader::next(Line& line) {
  if (skipping_ && !skip()) return tidy(), false;
  const std::size_t end = buffer_.find('\n', at_);
  const std::size_t length = (end == std::string::npos ? buffer_.size() : end) - at_;
  if (length > most_bytes_) {
    line = {{}, true};
    skipping_ = true;
    skip();
    return true;
  }
  if (end == std::string::npos) return tidy(), false;
  line = {buffer_.substr(at_, length), false};
  if (line.text.ends_with('\r')) line.text.pop_back();
  at_ = end + 1;
  return true;
}

}  // namespace onemap::control
