#include "render/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace onemap::render {
namespace {

constexpr int kMaxLeftovers = 100;  // of writers that were killed, or write the same path now

Error system_error(const std::string& path, const char* what, int code) {
  return Error{path, std::string(what) + ": " + std::strerror(code)};  // NOLINT(concurrency-mt-unsafe)
}

// 0, or the errno of the step that failed.
int write_all(int fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

Status write_file(const std::string& path, std::span<const std::uint8_t> bytes) {
  std::string temporary;
  int fd = -1;
  for (int i = 0; i < kMaxLeftovers && fd < 0; ++i) {
    temporary = path + ".partial" + std::to_string(i);
    fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && errno != EEXIST) break;
  }
  if (fd < 0) return system_error(path, "cannot write", errno);
  int code = write_all(fd, bytes);
  if (::close(fd) != 0 && code == 0) code = errno;
  if (code == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) code = errno;
  if (code == 0) return success();
  ::unlink(temporary.c_str());
  return system_error(path, "cannot write", code);
}

Result<std::vector<std::uint8_t>> read_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return system_error(path, "cannot read", errno);
  std::vector<std::uint8_t> bytes;
  std::size_t used = 0;
  int code = 0;
  for (;;) {
    bytes.resize(used + (std::size_t{1} << 20));
    const ssize_t n = ::read(fd, bytes.data() + used, bytes.size() - used);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) code = errno;
    if (n <= 0) break;
    used += static_cast<std::size_t>(n);
  }
  ::close(fd);
  if (code != 0) return system_error(path, "cannot read", code);
  bytes.resize(used);
  return bytes;
}

}  // namespace onemap::render
