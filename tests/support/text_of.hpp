#pragma once
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/base/file.hpp"

namespace onemap::test {

// A file's whole text; empty when it cannot be read.
inline std::string text_of(const std::filesystem::path& file) {
  auto text = read_text_file(file.string());
  return text ? std::move(*text) : std::string();
}

// Its lines, without their ends.
inline std::vector<std::string> lines_of(const std::filesystem::path& file) {
  const std::string text = text_of(file);
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

}  // namespace onemap::test
