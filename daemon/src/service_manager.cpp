#include "daemon/service_manager.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kPlace = "NOTIFY_SOCKET";
constexpr timeval kPatience{1, 0};  // a manager that takes nothing does not hold up the daemon for longer

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::optional<long long> number(const std::string& text) {
  long long value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = code == std::errc{} && end == text.data() + text.size() && value > 0;
  return good ? std::optional(value) : std::nullopt;
}

}  // namespace

ServiceManager::Environment ServiceManager::environment() {
  return {variable("NOTIFY_SOCKET"), variable("WATCHDOG_USEC"), variable("WATCHDOG_PID")};
}

ServiceManager::ServiceManager(const Environment& environment) {
  if (environment.socket.empty()) return;
  address_ = environment.socket;
  if (address_[0] != '/' && address_[0] != '@') wrong_ = {kPlace, "neither a path nor an abstract name"};
  if (address_.size() >= sizeof sockaddr_un::sun_path) wrong_ = {kPlace, "longer than a Unix socket's name can be"};
  if (address_[0] == '@') address_[0] = '\0';
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0) wrong_ = {kPlace, std::string("cannot make a socket: ") + std::strerror(errno)};
  ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  const bool ours = environment.watchdog_pid.empty() || number(environment.watchdog_pid) == ::getpid();
  if (const auto us = number(environment.watchdog_us); us && ours) watchdog_ = std::chrono::microseconds(*us);
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

Status ServiceManager::send(const std::string& text) const {
  if (!present()) return success();
  if (!wrong_.reason.empty()) return wrong_;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  const auto sent =
      ::sendto(socket_, text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), length);
  return sent >= 0 ? success() : Error{kPlace, std::string("cannot tell the service manager: ") + std::strerror(errno)};
}

Status ServiceManager::ready() { return send("READY=1"); }

Status ServiceManager::reloading(Instant now) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count();
  return send(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", us));
}

Status ServiceManager::stopping() { return send("STOPPING=1"); }

Status ServiceManager::alive() { return send("WATCHDOG=1"); }

// A line end would begin a message of its own.
Status ServiceManager::say(std::string_view one_line) { return send("STATUS=" + printable(one_line)); }

}  // namespace onemap::daemon
