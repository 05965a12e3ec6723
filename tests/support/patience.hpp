#pragma once
#include <string_view>

namespace onemap::test {

// How many times longer a test waits for what a program does: AddressSanitizer makes ours about ten times slower,
// ThreadSanitizer forty times.
inline constexpr int patience_with(std::string_view sanitizer) {
  if (sanitizer.empty()) return 1;
  return sanitizer == "thread" ? 15 : 6;
}
inline constexpr bool kSanitized = !std::string_view(ONEMAP_SANITIZE).empty();
inline constexpr int kPatience = patience_with(ONEMAP_SANITIZE);

}  // namespace onemap::test
