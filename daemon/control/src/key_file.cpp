#include "control/key_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>

namespace onemap::control {

namespace {
constexpr std::size_t kMostBytes = 200;
constexpr mode_t kOthers = 077;

Error failed(const std::string& file, const std::string& what, int code = errno) {
  return {file, what + ": " + std::generic_category().message(code)};
}

struct Descriptor {
  int fd;
  explicit Descriptor(int of) : fd(of) {}
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : file.substr(0, slash);
}

// The service's user, of what root installs for it.
void give_to_service(int fd, const std::string& file) {
  if (::geteuid() != 0 || !file.starts_with("/etc/onemap/")) return;
  const passwd* const user = ::getpwnam("onemap");
  if (user != nullptr && ::fchown(fd, user->pw_uid, user->pw_gid) != 0) return;  // then root's: the daemon says so
}

Status put(int fd, const std::string& file, const std::string& text) {
  if (::write(fd, text.data(), text.size()) != static_cast<ssize_t>(text.size())) return failed(file, "cannot write");
  if (::fchmod(fd, 0600) != 0) return failed(file, "cannot be made private");
  give_to_service(fd, file);
  if (::fsync(fd) != 0) return failed(file, "cannot sync to the disk");
  return success();
}

// A link fails where there is a file, a rename replaces it.
Status put_in_place(const std::string& temporary, const std::string& file, Replace replace) {
  if (replace == Replace::yes) {
    if (::rename(temporary.c_str(), file.c_str()) != 0) return failed(file, "cannot put in place");
  } else if (::link(temporary.c_str(), file.c_str()) != 0) {
    if (errno == EEXIST) return Error{file, "is there already; it is left as it is"};
    return failed(file, "cannot put in place");
  }
  const Descriptor folder(::open(folder_of(file).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.fd >= 0 && ::fsync(folder.fd) != 0 && errno != EINVAL && errno != ENOTSUP)
    return failed(file, "cannot sync its folder to the disk");
  return success();
}
}  // namespace

std::string secret_line(std::string_view kind, const comms::Secret32& secret) {
  std::string line(kind);
  line += ' ';
  for (const auto byte : secret.bytes) line += fmt::format("{:02x}", byte);
  return line;
}

Result<comms::Secret32> parse_secret(const std::string& line, std::string_view kind) {
  const std::string expected = fmt::format("expected one line: {} and 64 hexadecimal digits", kind);
  std::string_view rest = line;
  while (!rest.empty() && (rest.back() == '\n' || rest.back() == '\r')) rest.remove_suffix(1);
  if (!rest.starts_with(kind) || rest.size() != kind.size() + 65 || rest[kind.size()] != ' ')
    return Error{"", expected};
  rest.remove_prefix(kind.size() + 1);
  comms::Secret32 secret;
  for (std::size_t i = 0; i < secret.bytes.size(); ++i) {
    const char* const pair = rest.data() + 2 * i;
    if (std::from_chars(pair, pair + 2, secret.bytes[i], 16).ptr != pair + 2) return Error{"", expected};
  }
  if (secret == comms::Secret32{}) return Error{"", "a key of zeros is none"};
  return secret;
}

Result<comms::Secret32> read_secret(const std::string& file, std::string_view kind) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.fd < 0) {
    const int code = errno;
    return failed(
        file,
        code == EACCES ? "may not be read by this user (chown it to the user that runs onemapd)" : "cannot be opened",
        code);
  }
  struct stat found {};
  if (::fstat(opened.fd, &found) != 0) return failed(file, "cannot be looked at");
  if (!S_ISREG(found.st_mode)) return Error{file, "is no regular file"};
  if ((found.st_mode & kOthers) != 0)
    return Error{file, fmt::format("holds a secret, and others may use it (mode {:04o}): chmod 600 {}; if somebody may "
                                   "have read it, make a new one",
                                   found.st_mode & 07777u, file)};
  std::array<char, kMostBytes> text{};
  const ssize_t size = ::read(opened.fd, text.data(), text.size());
  if (size < 0) return failed(file, "cannot be read");
  auto secret = parse_secret(std::string(text.data(), static_cast<std::size_t>(size)), kind);
  comms::wipe({reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  if (!secret) return Error{file, secret.error().reason};
  return secret;
}

Status write_secret(const std::string& file, std::string_view kind, const comms::Secret32& secret, Replace replace) {
  std::string temporary = file + ".XXXXXX";
  const Descriptor made(::mkostemp(temporary.data(), O_CLOEXEC));  // mode 0600
  if (made.fd < 0) return failed(file, "cannot write to its folder");
  Status status = put(made.fd, file, secret_line(kind, secret) + "\n");
  if (status) status = put_in_place(temporary, file, replace);
  if (!status || replace == Replace::no) ::unlink(temporary.c_str());
  return status;
}

Status fill_random(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::getrandom(bytes.data(), bytes.size(), 0);
    if (n < 0 && errno != EINTR) return failed("random bytes", "the kernel has none");
    if (n > 0) bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return success();
}

Result<comms::Secret32> new_secret() {
  comms::Secret32 secret;
  if (auto filled = fill_random(secret.bytes); !filled) return filled.error();
  return secret;
}

}  // namespace onemap::control
