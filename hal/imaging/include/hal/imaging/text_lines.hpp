#pragma once
#include <string_view>
#include <vector>

namespace onemap::hal::imaging {

// Calls each(line number, words) for every line that has words, without comments.
template <class Each>
void for_each_line(std::string_view text, Each each) {
  std::vector<std::string_view> words;
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(line.size() < text.size() ? line.size() + 1 : line.size());
    line = line.substr(0, line.find('#'));
    constexpr std::string_view kBlank = " \t\r\f\v";
    words.clear();
    while (true) {
      const std::size_t begin = line.find_first_not_of(kBlank);
      if (begin == std::string_view::npos) break;
      line.remove_prefix(begin);
      const std::size_t size = line.substr(0, line.find_first_of(kBlank)).size();
      words.push_back(line.substr(0, size));
      line.remove_prefix(size);
    }
    if (!words.empty()) each(number, words);
  }
}

}  // namespace onemap::hal::imaging
