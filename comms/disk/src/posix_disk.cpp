#include "comms/disk/posix_disk.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

namespace onemap::comms {

std::string_view words(DiskFault fault) {
  switch (fault) {
    case DiskFault::none:
      return "works";
    case DiskFault::no_space:
      return "is full";
    case DiskFault::read_only:
      return "cannot be written to";
    case DiskFault::failing:
      return "fails";
    case DiskFault::gone:
      return "is not there any more";
  }
  return "fails";
}

namespace {
constexpr const char* kLock = "lock";
constexpr std::size_t kOpenFiles = 16;

DiskFault fault_of(int error) {
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) return DiskFault::no_space;
  if (error == EROFS || error == EACCES || error == EPERM) return DiskFault::read_only;
  return error == ENOENT || error == ENOTDIR ? DiskFault::gone : DiskFault::failing;
}
DiskFault last_fault() { return fault_of(errno); }

// fdatasync of a file that nobody can find any more promises nothing.
DiskFault sync_file(int fd, int folder) {
  if (::fdatasync(fd) != 0 || ::fsync(folder) != 0) return last_fault();
  struct stat entry {};
  if (::fstat(fd, &entry) != 0) return last_fault();
  return entry.st_nlink == 0 ? DiskFault::gone : DiskFault::none;
}
}  // namespace

struct PosixDisk::Impl {
  int folder = -1, lock = -1;
  const std::atomic<bool>* given_up = nullptr;  // nullptr: the folder is this process's own
  bool reads_only() const { return given_up != nullptr; }
  bool gave_up() const { return reads_only() && *given_up; }
  struct Open {
    std::string name;
    int fd;
  };
  std::list<Open> files;  // the one that was used last is first

  std::mutex mutex;
  std::condition_variable changed;
  int to_sync = -1;  // a descriptor of its own: the file may be closed or cut meanwhile
  bool syncing = false, over = false;
  DiskFault result = DiskFault::none;
  std::thread thread;

  ~Impl() {
    {
      const std::lock_guard guard(mutex);
      over = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
    for (const Open& file : files) ::close(file.fd);
    if (lock >= 0) ::close(lock);
    if (folder >= 0) ::close(folder);
  }
  int descriptor(const std::string& name, bool make);
  void forget(const std::string& name);
  void run();
};

// -1 and errno, if there is no such file.
int PosixDisk::Impl::descriptor(const std::string& name, bool make) {
  for (auto it = files.begin(); it != files.end(); ++it) {
    if (it->name != name) continue;
    files.splice(files.begin(), files, it);
    return files.front().fd;
  }
  constexpr int kRead = O_RDONLY | O_NONBLOCK | O_CLOEXEC;
  int fd = reads_only() ? ::openat(folder, name.c_str(), kRead)
                        : ::openat(folder, name.c_str(), O_RDWR | O_CLOEXEC | (make ? O_CREAT : 0), 0640);
  if (fd < 0 && !make && (errno == EROFS || errno == EACCES)) fd = ::openat(folder, name.c_str(), kRead);
  if (fd < 0) return -1;
  files.push_front({name, fd});
  if (files.size() > kOpenFiles) {
    ::close(files.back().fd);
    files.pop_back();
  }
  return fd;
}

void PosixDisk::Impl::forget(const std::string& name) {
  for (auto it = files.begin(); it != files.end(); ++it) {
    if (it->name != name) continue;
    ::close(it->fd);
    files.erase(it);
    return;
  }
}

void PosixDisk::Impl::run() {
  std::unique_lock guard(mutex);
  for (;;) {
    changed.wait(guard, [this] { return over || to_sync >= 0; });
    if (to_sync < 0) return;
    const int fd = std::exchange(to_sync, -1);
    guard.unlock();
    const DiskFault fault = sync_file(fd, folder);
    ::close(fd);
    guard.lock();
    result = fault;
    syncing = false;
    changed.notify_all();
  }
}

Result<std::unique_ptr<PosixDisk>> PosixDisk::open(const std::string& folder) {
  const auto failed = [&](std::string_view what) {
    return Error{folder, fmt::format("{}: {}", what, std::strerror(errno))};
  };
  if (::mkdir(folder.c_str(), 0750) != 0 && errno != EEXIST) return failed("cannot make this folder");
  auto impl = std::make_unique<Impl>();
  impl->folder = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (impl->folder < 0) return failed("cannot open this folder");
  impl->lock = ::openat(impl->folder, kLock, O_RDWR | O_CREAT | O_CLOEXEC, 0640);
  if (impl->lock < 0) return failed("cannot be written to");
  if (::flock(impl->lock, LOCK_EX | LOCK_NB) != 0) return Error{folder, "another process keeps its log here"};
  impl->thread = std::thread([raw = impl.get()] { raw->run(); });
  return std::unique_ptr<PosixDisk>(new PosixDisk(std::move(impl)));
}

Result<std::unique_ptr<PosixDisk>> PosixDisk::open_to_read(const std::string& folder,
                                                           const std::atomic<bool>& given_up) {
  auto impl = std::make_unique<Impl>();
  impl->given_up = &given_up;
  impl->folder = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (impl->folder < 0) return Error{folder, fmt::format("cannot open this folder: {}", std::strerror(errno))};
  return std::unique_ptr<PosixDisk>(new PosixDisk(std::move(impl)));
}

PosixDisk::PosixDisk(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PosixDisk::~PosixDisk() = default;

std::optional<std::vector<std::string>> PosixDisk::list() {
  const int fd = ::openat(impl_->folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* directory = fd < 0 ? nullptr : ::fdopendir(fd);
  if (directory == nullptr) {
    if (fd >= 0) ::close(fd);
    return std::nullopt;
  }
  std::vector<std::string> names;
  while (const dirent* entry = ::readdir(directory)) {
    const std::string name = entry->d_name;
    if (name != "." && name != ".." && name != kLock) names.push_back(name);
  }
  ::closedir(directory);
  return names;
}

std::optional<std::uint64_t> PosixDisk::size(const std::string& name) {
  struct stat entry {};
  if (impl_->gave_up()) return std::nullopt;
  if (::fstatat(impl_->folder, name.c_str(), &entry, 0) != 0 || !S_ISREG(entry.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(entry.st_size);
}

std::optional<std::size_t> PosixDisk::read(const std::string& name, std::uint64_t at, std::span<std::uint8_t> into) {
  const int fd = impl_->gave_up() ? -1 : impl_->descriptor(name, false);
  if (fd < 0) return std::nullopt;
  std::size_t done = 0;
  while (done < into.size()) {
    const auto n = ::pread(fd, into.data() + done, into.size() - done, static_cast<off_t>(at + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return std::nullopt;
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

DiskFault PosixDisk::write(const std::string& name, std::uint64_t at, std::span<const std::uint8_t> bytes) {
  if (impl_->reads_only()) return DiskFault::read_only;
  const int fd = impl_->descriptor(name, true);
  if (fd < 0) return last_fault();
  while (!bytes.empty()) {
    const auto n = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return last_fault();
    at += static_cast<std::uint64_t>(n);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return DiskFault::none;
}

DiskFault PosixDisk::cut(const std::string& name, std::uint64_t size) {
  if (impl_->reads_only()) return DiskFault::read_only;
  const int fd = impl_->descriptor(name, false);
  if (fd < 0 || ::ftruncate(fd, static_cast<off_t>(size)) != 0) return last_fault();
  return DiskFault::none;
}

DiskFault PosixDisk::remove(const std::string& name) {
  if (impl_->reads_only()) return DiskFault::read_only;
  impl_->forget(name);
  return ::unlinkat(impl_->folder, name.c_str(), 0) == 0 ? DiskFault::none : last_fault();
}

DiskFault PosixDisk::rename(const std::string& name, const std::string& to) {
  if (impl_->reads_only()) return DiskFault::read_only;
  impl_->forget(name);
  return ::renameat(impl_->folder, name.c_str(), impl_->folder, to.c_str()) == 0 ? DiskFault::none : last_fault();
}

void PosixDisk::begin_sync(const std::string& name) {
  if (impl_->reads_only()) return;  // nothing is written, so all is on the disk
  const int fd = impl_->descriptor(name, false);
  const int own = fd < 0 ? -1 : ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
  const std::lock_guard guard(impl_->mutex);
  if (own < 0) {
    impl_->result = last_fault();
    return;
  }
  impl_->to_sync = own;
  impl_->syncing = true;
  impl_->changed.notify_all();
}

std::optional<DiskFault> PosixDisk::synced(bool wait) {
  std::unique_lock guard(impl_->mutex);
  if (wait) impl_->changed.wait(guard, [this] { return !impl_->syncing; });
  return impl_->syncing ? std::nullopt : std::optional(impl_->result);
}

}  // namespace onemap::comms
