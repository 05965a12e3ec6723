#include "hal/base/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace onemap {
namespace {

constexpr int kMostWriters = 100;  // of one path at a time

Error system_error(const std::string& path, const std::string& what, int code) {
  return Error{path, what + ": " + std::generic_category().message(code)};
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

// How large a file says that it is; those of the kernel say 0.
std::size_t stated_size(int fd) {
  struct stat found {};
  return ::fstat(fd, &found) == 0 && found.st_size > 0 ? static_cast<std::size_t>(found.st_size) : 0;
}

bool is_regular(int fd) {
  struct stat found {};
  return ::fstat(fd, &found) == 0 && S_ISREG(found.st_mode);
}

Error too_large(const std::string& path, std::size_t most_bytes) {
  const bool mib = most_bytes >= std::size_t{1} << 20;
  return Error{path, fmt::format("cannot read: larger than {} {}", most_bytes >> (mib ? 20 : 10), mib ? "MiB" : "KiB")};
}

// Reads to the end; Bytes is a vector of bytes or a string, its memory is used again.
template <class Bytes>
Status read_all(const Descriptor& file, const std::string& path, Bytes& into, std::size_t most_bytes) {
  constexpr std::size_t kLeastRoom = 4096;
  const std::size_t stated = stated_size(file.get());
  if (stated > most_bytes) return too_large(path, most_bytes);
  into.resize(std::max(stated + 1, kLeastRoom));  // the end shows itself in the byte behind it
  std::size_t used = 0;
  for (;;) {
    const ssize_t n = ::read(file.get(), into.data() + used, into.size() - used);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path, "cannot read", errno);
    if (n == 0) break;
    used += static_cast<std::size_t>(n);
    if (used > most_bytes) return too_large(path, most_bytes);
    if (used == into.size()) into.resize(2 * used);
  }
  into.resize(used);
  return success();
}

template <class Bytes>
Result<Bytes> read_whole(const std::string& path, std::size_t most_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) return system_error(path, "cannot read", errno);
  Bytes bytes;
  if (auto status = read_all(file, path, bytes, most_bytes); !status) return status.error();
  return bytes;
}

}  // namespace

Result<std::vector<std::uint8_t>> read_file(const std::string& path, std::size_t most_bytes) {
  return read_whole<std::vector<std::uint8_t>>(path, most_bytes);
}

Result<std::string> read_text_file(const std::string& path, std::size_t most_bytes) {
  return read_whole<std::string>(path, most_bytes);
}

Status read_regular_file(const std::string& path, std::vector<std::uint8_t>& into, std::size_t most_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file.valid()) return system_error(path, "cannot read", errno);
  if (!is_regular(file.get())) return Error{path, "cannot read: not a regular file"};
  return read_all(file, path, into, most_bytes);
}

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

Status write_text_file(const std::string& path, std::string_view text, Durable durable) {
  return write_file(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, durable);
}

}  // namespace onemap
