#include "daemon/control/output_buffer.hpp"

#include <sys/socket.h>

#include <cerrno>

namespace onemap::daemon {

namespace {
constexpr std::size_t kTidyAbove = 64u << 10;  // bytes that were taken and are still held
}

void OutputBuffer::add(std::string_view bytes) { bytes_.append(bytes); }

bool OutputBuffer::flush(int socket) {
  while (pending() > 0) {
    const ssize_t sent = send(socket, bytes_.data() + at_, pending(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      if (at_ > kTidyAbove) bytes_.erase(0, at_), at_ = 0;
      return errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS;
    }
    at_ += static_cast<std::size_t>(sent);
    taken_ += static_cast<std::size_t>(sent);
  }
  bytes_ = {};
  at_ = 0;
  return true;
}

}  // namespace onemap::daemon
