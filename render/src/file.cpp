#include "render/file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace onemap::render {
namespace {

constexpr int kMostWriters = 100;  // of one path at a time

Error system_error(const std::string& path, const std::string& what, int code) {
  return Error{path, what + ": " + std::strerror(code)};  // NOLINT(concurrency-mt-unsafe)
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  int close() { return ::close(std::exchange(fd_, -1)) == 0 ? 0 : errno; }

 private:
  int fd_;
};

struct Place {
  std::string folder, name;
};

Place split(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return {".", path};
  return {slash == 0 ? "/" : path.substr(0, slash), path.substr(slash + 1)};
}

// Renaming replaces whatever it finds: a device, too.
Status check_target(const std::string& path, const Place& place) {
  if (path.empty()) return Error{path, "cannot write: the path is empty"};
  if (place.name.empty()) return Error{path, "cannot write: the path ends in '/', so it names a folder"};
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0 || S_ISREG(found.st_mode)) return success();
  return Error{path, S_ISDIR(found.st_mode) ? "cannot write: is a folder" : "cannot write: is not a regular file"};
}

// Whether the name is still the open file's: its last writer may have renamed it into place since it was opened.
bool is_named(int folder, const std::string& name, int fd) {
  struct stat by_name {};
  struct stat by_fd {};
  return ::fstatat(folder, name.c_str(), &by_name, AT_SYMLINK_NOFOLLOW) == 0 && ::fstat(fd, &by_fd) == 0 &&
         by_name.st_ino == by_fd.st_ino && by_name.st_dev == by_fd.st_dev;
}

struct Temporary {
  std::string name;
  Descriptor file;
};

// Empty, and locked until it is closed: what a killed writer left is not locked and is used again.
Result<Temporary> open_temporary(const Descriptor& folder, const std::string& path, const std::string& name) {
  int code = EAGAIN;
  for (int i = 0; i < kMostWriters; ++i) {
    std::string temporary = name + ".partial" + std::to_string(i);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    Descriptor file(::openat(folder.get(), temporary.c_str(), kFlags, 0666));
    if (!file.valid()) {
      code = errno;
      continue;
    }
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) continue;
    if (!is_named(folder.get(), temporary, file.get()) || ::ftruncate(file.get(), 0) != 0) continue;
    return Temporary{std::move(temporary), std::move(file)};
  }
  return system_error(path, "cannot write", code);
}

int write_all(int fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return 0;
}

// What was tried last, and its errno; 0: all went well.
struct Step {
  const char* what;
  int code;
};

Step put_in_place(const Descriptor& folder, const Temporary& temporary, const std::string& name,
                  std::span<const std::uint8_t> bytes, Durable durable) {
  const int fd = temporary.file.get();
  if (const int code = write_all(fd, bytes); code != 0) return {"cannot write", code};
  if (durable == Durable::yes && ::fsync(fd) != 0) return {"cannot sync to the disk", errno};
  const int renamed = ::renameat(folder.get(), temporary.name.c_str(), folder.get(), name.c_str());
  return {"cannot put in place", renamed == 0 ? 0 : errno};
}

// Some file systems cannot sync a folder, and say so.
int sync_folder(const Descriptor& folder) {
  return ::fsync(folder.get()) == 0 || errno == EINVAL || errno == ENOTSUP ? 0 : errno;
}

}  // namespace

Status write_file(const std::string& path, std::span<const std::uint8_t> bytes, Durable durable) {
  const Place place = split(path);
  if (auto status = check_target(path, place); !status) return status;
  const Descriptor folder(::open(place.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.valid()) return system_error(path, "cannot write: folder '" + place.folder + "'", errno);
  auto temporary = open_temporary(folder, path, place.name);
  if (!temporary) return temporary.error();
  if (const auto [what, code] = put_in_place(folder, *temporary, place.name, bytes, durable); code != 0) {
    ::unlinkat(folder.get(), temporary->name.c_str(), 0);
    return system_error(path, what, code);
  }
  if (const int code = temporary->file.close(); code != 0) return system_error(path, "cannot close", code);
  const int code = durable == Durable::yes ? sync_folder(folder) : 0;
  if (code != 0) return system_error(path, "is written, but its folder cannot be synced to the disk", code);
  return success();
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
