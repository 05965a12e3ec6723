#include "daemon/set_aside.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace onemap::daemon {

namespace {
constexpr int kMost = 9;
}

Result<std::string> set_aside(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  int number = 1;
  while (number < kMost && fs::exists(fs::symlink_status(fmt::format("{}.corrupt-{}", file, number), error))) ++number;
  std::string name = fmt::format("{}.corrupt-{}", file, number);
  fs::rename(file, name, error);
  if (error) return Error{file, "cannot be set aside: " + error.message()};
  return name;
}

}  // namespace onemap::daemon
