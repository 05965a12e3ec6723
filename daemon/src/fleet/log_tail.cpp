#include "daemon/fleet/log_tail.hpp"

#include <algorithm>
#include <fstream>

#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {
constexpr std::streamoff kLooked = 8192;
}

std::vector<std::string> last_lines(const std::string& file, std::size_t count) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  if (!in || size < 0) return {};
  in.seekg(std::max<std::streamoff>(0, size - kLooked));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(printable(line));
  if (size > kLooked && lines.size() > 1) lines.erase(lines.begin());  // cut at its beginning
  if (lines.size() > count) lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(count));
  return lines;
}

}  // namespace onemap::daemon
