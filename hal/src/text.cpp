#include "hal/base/text.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace onemap {

namespace {

struct Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: not UTF-8
};

// The character at the beginning of text (not empty): overlong forms, surrogates and codes beyond U+10FFFF are none.
Character first_of(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = at(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  char32_t code = lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((at(i) & 0xC0u) != 0x80u) return {};
    code = (code << 6) | (at(i) & 0x3Fu);
  }
  constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
  const bool good = code >= kSmallest[bytes] && code <= 0x10FFFF && !(code >= 0xD800 && code <= 0xDFFF);
  return good ? Character{code, bytes} : Character{};
}

bool is_plain(char32_t code) {
  constexpr std::array<std::pair<char32_t, char32_t>, 8> kOdd{{{0x00, 0x1F},
                                                               {0x7F, 0x9F},
                                                               {0x061C, 0x061C},
                                                               {0x200B, 0x200F},
                                                               {0x2028, 0x202E},
                                                               {0x2060, 0x206F},
                                                               {0xFEFF, 0xFEFF},
                                                               {0xFFF9, 0xFFFB}}};
  for (const auto& [first, last] : kOdd)
    if (code >= first && code <= last) return false;
  return true;
}

}  // namespace

std::string printable(std::string_view foreign) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  out.reserve(foreign.size());
  while (!foreign.empty()) {
    const Character next = first_of(foreign);
    const std::size_t bytes = next.bytes == 0 ? 1 : next.bytes;
    if (next.bytes != 0 && is_plain(next.code)) {
      out.append(foreign.substr(0, bytes));
    } else {
      for (const char c : foreign.substr(0, bytes)) {
        const auto byte = static_cast<std::uint8_t>(c);
        out.append("\\x").append(1, kDigits[byte >> 4]).append(1, kDigits[byte & 15]);
      }
    }
    foreign.remove_prefix(bytes);
  }
  return out;
}

}  // namespace onemap
