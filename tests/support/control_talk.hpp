#pragma once
// A control client as a test has it: it may be rude.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "control/line_reader.hpp"
#include "control/protocol.hpp"
#include "support/patience.hpp"

namespace onemap::test {

// A stream socket connected to a path; -1 and errno: not.
inline int connect_to(const std::string& path, int flags = 0) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  if (fd < 0 || connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

class Talk {
 public:
  explicit Talk(int fd) : fd_(fd) {}
  explicit Talk(const std::string& path) : fd_(connect_to(path)) {}
  Talk(Talk&& other) noexcept : fd_(std::exchange(other.fd_, -1)), reader_(std::move(other.reader_)) {}
  ~Talk() {
    if (fd_ >= 0) close(fd_);
  }
  bool connected() const { return fd_ >= 0; }
  int fd() const { return fd_; }
  bool say(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  bool ask(std::string_view request) const { return say(std::string(request) + "\n"); }
  // The next object; null: none within the time, or the other end is gone.
  control::Json hear(std::chrono::milliseconds limit = std::chrono::seconds(20)) {
    const auto line = hear_line(limit);
    return line ? control::Json::parse(*line, nullptr, false) : control::Json();
  }
  std::optional<std::string> hear_line(std::chrono::milliseconds limit = std::chrono::seconds(20)) {
    const auto end = std::chrono::steady_clock::now() + kPatience * limit;
    control::LineReader::Line line;
    while (!reader_.next(line))
      if (!read_some(end)) return std::nullopt;
    return line.text;
  }
  // The next one of this class, over others.
  control::Json hear_class(std::string_view name, std::chrono::milliseconds limit = std::chrono::seconds(20)) {
    const auto end = std::chrono::steady_clock::now() + kPatience * limit;
    while (std::chrono::steady_clock::now() < end) {
      auto object = hear(limit);
      if (!object.is_object() || object.value("class", "") == name) return object;
    }
    return nullptr;
  }
  // Whether the other end closes the connection; what comes before is thrown away.
  bool is_closed(std::chrono::milliseconds limit = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + kPatience * limit;
    while (read_some(end)) reader_ = control::LineReader(control::kMostAnswerBytes);
    return ended_;
  }

 private:
  bool read_some(std::chrono::steady_clock::time_point end) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd waited{fd_, POLLIN, 0};
    if (left.count() <= 0 || poll(&waited, 1, static_cast<int>(left.count())) <= 0) return false;
    std::array<char, 65536> bytes;
    const ssize_t got = recv(fd_, bytes.data(), bytes.size(), 0);
    ended_ = got <= 0;
    if (got > 0) reader_.add({bytes.data(), static_cast<std::size_t>(got)});
    return got > 0;
  }
  int fd_;
  bool ended_ = false;
  control::LineReader reader_{control::kMostAnswerBytes};
};

}  // namespace onemap::test
