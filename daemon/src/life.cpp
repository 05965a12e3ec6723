#include "daemon/life.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "daemon/set_aside.hpp"
#include "hal/base/file.hpp"

namespace onemap::daemon {

namespace {
constexpr std::uint64_t kGreatest = std::uint64_t{1} << 63;  // beyond it is no life but somebody's joke

// What the file says; 0 and no error when there is none.
Result<std::uint64_t> read_number(const std::string& file) {
  std::error_code none;
  if (!std::filesystem::exists(file, none)) return std::uint64_t{0};
  const auto read = read_text_file(file, kSmallFileBytes);
  if (!read) return read.error();
  const std::string& text = *read;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = end == text.data() + text.size() || *end == '\n';
  if (error != std::errc{} || !whole || number >= kGreatest) return Error{file, "not the number of a life"};
  return number;
}
}  // namespace

Status LifeCounter::begin(std::uint64_t wall_clock_ns) {
  number_ = std::max<std::uint64_t>(wall_clock_ns, 1);
  const auto last = read_number(file_);
  if (!last) {
    const auto aside = set_aside(file_);
    if (auto kept = keep(number_); !kept) return kept;
    return Error{last.error().place,
                 last.error().reason + "; " + (aside ? "set aside as " + *aside : aside.error().reason)};
  }
  return keep(std::max(number_, *last + 1));
}

Status LifeCounter::begin_after(std::uint64_t outlived) { return keep(std::max(number_, outlived) + 1); }

Status LifeCounter::keep(std::uint64_t number) {
  number_ = number;
  return write_text_file(file_, fmt::format("{}\n", number));
}

}  // namespace onemap::daemon
