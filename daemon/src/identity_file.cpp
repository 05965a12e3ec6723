#include "daemon/identity_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "hal/base/file.hpp"

namespace onemap::daemon {

namespace {

int digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

std::optional<comms::SecretSeed> seed_from(const std::string& text) {
  comms::SecretSeed seed{};
  if (text.size() != 2 * seed.size() + 1 || text.back() != '\n') return std::nullopt;
  for (std::size_t k = 0; k < seed.size(); ++k) {
    const int high = digit(text[2 * k]), low = digit(text[2 * k + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    seed[k] = static_cast<std::uint8_t>(16 * high + low);
  }
  return seed;
}

comms::SecretSeed new_seed() {
  comms::SecretSeed seed{};
  if (::getrandom(seed.data(), seed.size(), 0) != static_cast<ssize_t>(seed.size()))
    throw std::runtime_error("the kernel gives no random bytes");
  return seed;
}

// Only if there is none yet: two daemons that start at once end with one key.
Status write_new(const std::string& file, const comms::SecretSeed& seed) {
  std::string text;
  for (const auto byte : seed) text += fmt::format("{:02x}", byte);
  text += '\n';
  const std::string draft = fmt::format("{}.new-{}", file, ::getpid());
  const int fd = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return Error{file, fmt::format("cannot be made: {}", std::strerror(errno))};
  const bool whole = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd) == 0;
  const int error = errno;
  ::close(fd);
  const bool placed = whole && (::link(draft.c_str(), file.c_str()) == 0 || errno == EEXIST);
  const int place_error = errno;
  ::unlink(draft.c_str());
  if (placed) return success();
  return Error{file, fmt::format("cannot be written: {}", std::strerror(whole ? place_error : error))};
}

}  // namespace

Result<comms::Identity> read_identity(const std::string& file) {
  struct stat entry {};
  if (::stat(file.c_str(), &entry) != 0) return Error{file, fmt::format("cannot be read: {}", std::strerror(errno))};
  if ((entry.st_mode & 077) != 0)
    return Error{file, "others may read this robot's key; chmod 600, and think about who has read it"};
  const auto text = read_text_file(file, kSmallFileBytes);
  if (!text) return text.error();
  const auto seed = seed_from(*text);
  if (!seed)
    return Error{file,
                 "is not a robot's key (64 hexadecimal digits); bring it back, or remove it and give the robot "
                 "another id: its team knows it by the old key"};
  return comms::Identity(*seed);
}

Result<comms::Identity> open_identity(const std::string& file) {
  struct stat entry {};
  if (::stat(file.c_str(), &entry) != 0 && errno == ENOENT)
    if (Status made = write_new(file, new_seed()); !made) return made.error();
  return read_identity(file);
}

comms::Identity passing_identity() { return comms::Identity(new_seed()); }

}  // namespace onemap::daemon
