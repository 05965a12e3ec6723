#include "hal/backends/replay/lists.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "hal/imaging/text_lines.hpp"

namespace onemap::hal::replay {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kMaxSeconds = 9'000'000'000;  // keeps nanoseconds within 63 bits

bool digit(char c) { return c >= '0' && c <= '9'; }

FrameTime time_of(const ListedImage& image) { return image.time; }
FrameTime time_of(const ListedPair& pair) { return pair.color.time; }
int line_of(const ListedImage& image) { return image.line; }
int line_of(const ListedPair& pair) { return pair.color.line; }

// Sorts by time and leaves out what repeats a time: the first line that gave it stays.
template <class Item>
void order(std::vector<Item>& items, std::vector<Error>& problems, const std::string& name) {
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return time_of(a) < time_of(b); });
  std::vector<Item> kept;
  for (Item& item : items) {
    if (!kept.empty() && time_of(kept.back()) == time_of(item)) {
      problems.push_back({fmt::format("{}:{}", name, line_of(item)),
                          fmt::format("the same time as in line {}", line_of(kept.back()))});
    } else {
      kept.push_back(std::move(item));
    }
  }
  items = std::move(kept);
}

Error wrong_count(std::string place, std::size_t words, const char* expected) {
  return {std::move(place), fmt::format("{} words where {} are expected", words, expected)};
}

}  // namespace

Result<FrameTime> parse_time(std::string_view text) {
  std::int64_t seconds = 0, nanoseconds = 0, unit = kSecond;
  std::size_t at = 0;
  for (; at < text.size() && digit(text[at]) && seconds <= kMaxSeconds; ++at) seconds = 10 * seconds + (text[at] - '0');
  bool good = at > 0 && seconds <= kMaxSeconds;
  if (good && at < text.size() && text[at] == '.') {
    for (++at; at < text.size() && digit(text[at]); ++at) {
      unit /= 10;
      nanoseconds += unit * (text[at] - '0');
    }
  }
  good = good && at == text.size();
  if (!good) return Error{"", fmt::format("'{}' is not a time in seconds", text)};
  return frame_time_from_ns(seconds * kSecond + nanoseconds);
}

ImageList parse_image_list(std::string_view text, const std::string& name) {
  ImageList list;
  imaging::for_each_line(text, [&](int number, const std::vector<std::string_view>& words) {
    const std::string place = fmt::format("{}:{}", name, number);
    if (words.size() != 2) return list.problems.push_back(wrong_count(place, words.size(), "2 (time path)"));
    const Result<FrameTime> time = parse_time(words[0]);
    if (!time) return list.problems.push_back({place, time.error().reason});
    list.images.push_back({*time, std::string(words[1]), number});
  });
  order(list.images, list.problems, name);
  return list;
}

PairList parse_associations(std::string_view text, const std::string& name) {
  PairList list;
  imaging::for_each_line(text, [&](int number, const std::vector<std::string_view>& words) {
    const std::string place = fmt::format("{}:{}", name, number);
    if (words.size() != 4) return list.problems.push_back(wrong_count(place, words.size(), "4 (time path time path)"));
    const Result<FrameTime> first = parse_time(words[0]), second = parse_time(words[2]);
    if (!first) return list.problems.push_back({place, first.error().reason});
    if (!second) return list.problems.push_back({place, second.error().reason});
    list.pairs.push_back({{*first, std::string(words[1]), number}, {*second, std::string(words[3]), number}});
    if (words[1].starts_with("depth/") && !words[3].starts_with("depth/"))
      std::swap(list.pairs.back().color, list.pairs.back().depth);
  });
  order(list.pairs, list.problems, name);
  return list;
}

std::vector<ListedPair> associate(const std::vector<ListedImage>& color, const std::vector<ListedImage>& depth,
                                  Duration max_dt) {
  std::vector<std::tuple<Duration, std::size_t, std::size_t>> near;  // apart, colour, depth
  std::size_t first = 0;
  for (std::size_t c = 0; c < color.size(); ++c) {
    while (first < depth.size() && depth[first].time < color[c].time - max_dt) ++first;
    for (std::size_t d = first; d < depth.size() && depth[d].time <= color[c].time + max_dt; ++d)
      near.emplace_back(std::chrono::abs(depth[d].time - color[c].time), c, d);
  }
  std::sort(near.begin(), near.end());
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> partner(color.size(), kNone);
  std::vector<bool> depth_used(depth.size(), false);
  for (const auto& [apart, c, d] : near) {
    if (partner[c] != kNone || depth_used[d]) continue;
    partner[c] = d;
    depth_used[d] = true;
  }
  std::vector<ListedPair> pairs;
  for (std::size_t c = 0; c < color.size(); ++c)
    if (partner[c] != kNone) pairs.push_back({color[c], depth[partner[c]]});
  return pairs;
}

}  // namespace onemap::hal::replay
