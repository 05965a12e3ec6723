#include "daemon/brightness.hpp"

namespace onemap::daemon {

namespace {
constexpr std::size_t kStep = 3 * 61;  // a prime number of pixels, so that no column is all that is seen
}  // namespace

double brightness_of(std::span<const std::uint8_t> rgb) {
  std::uint64_t sum = 0, count = 0;
  for (std::size_t at = 1; at < rgb.size(); at += kStep) sum += rgb[at], ++count;
  return count == 0 ? 0.0 : static_cast<double>(sum) / static_cast<double>(count);
}

}  // namespace onemap::daemon
