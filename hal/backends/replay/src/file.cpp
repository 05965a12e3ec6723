#include "file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

namespace onemap::hal::replay {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxFileBytes = 256u << 20;

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

Status read_file(const fs::path& path, std::vector<std::uint8_t>& into) {
  std::error_code code;
  const bool regular = fs::is_regular_file(path, code);
  if (code) return Error{path.string(), "cannot be read: " + code.message()};
  if (!regular) return Error{path.string(), "cannot be read: not a file"};
  const std::uintmax_t size = fs::file_size(path, code);
  if (code) return Error{path.string(), "cannot be read: " + code.message()};
  if (size > kMaxFileBytes) return Error{path.string(), "cannot be read: larger than 256 MiB"};
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) return Error{path.string(), std::string("cannot be read: ") + std::strerror(errno)};
  into.resize(size);
  into.resize(std::fread(into.data(), 1, into.size(), file.get()));
  if (std::ferror(file.get())) return Error{path.string(), std::string("cannot be read: ") + std::strerror(errno)};
  return success();
}

}  // namespace onemap::hal::replay
