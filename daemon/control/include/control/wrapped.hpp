#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace onemap::control {

constexpr std::size_t kTerminalColumns = 100;

// A help text with no line wider than so many columns, as long as its words allow that. What a line goes on in stands
// below its beginning; of an option's line, below what is said of the option: the text behind two blanks or more.
std::string wrapped(std::string_view text, std::size_t columns = kTerminalColumns);

}  // namespace onemap::control
