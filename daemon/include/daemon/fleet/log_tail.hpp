#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace onemap::daemon {

// The last lines of a log file, made safe to show; none when it cannot be read. Only the file's last 8 kB are looked
// at.
std::vector<std::string> last_lines(const std::string& file, std::size_t count);

}  // namespace onemap::daemon
