#pragma once
#include <string>
#include <string_view>

namespace onemap {

// Makes text from outside (names, paths, what a device or a peer says) safe for a log, JSON and a terminal: printable
// UTF-8 stays byte for byte; control characters (C0, DEL, C1), line and paragraph separators, characters that change
// the direction of writing, and bytes that are not UTF-8 become \xHH, byte by byte. The result is valid UTF-8.
std::string printable(std::string_view foreign);

}  // namespace onemap
