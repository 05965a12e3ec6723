#include "daemon/control/listener.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "comms/udp/udp_port.hpp"
#include "daemon/addresses.hpp"

namespace onemap::daemon {

namespace {

constexpr int kBacklog = 64;
constexpr int kFlags = SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK;
constexpr mode_t kForEverybody = 0666;  // who may get there is the folder's to say, who may change something is ours

Error failed(const std::string& place, const char* what) {
  return {place, fmt::format("{}: {}", what, std::strerror(errno))};
}

// Closes on the way out, unless it was released.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  int release() { return std::exchange(fd, -1); }
};

Result<sockaddr_un> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return Error{path, fmt::format("is longer than the {} bytes that a socket's path may have; say control.socket",
                                   sizeof address.sun_path - 1)};
  path.copy(address.sun_path, path.size());
  return address;
}

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

// Nobody listens at this socket any more.
bool is_left_over(const std::string& path, const sockaddr_un& address) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0 || !S_ISSOCK(found.st_mode)) return false;
  const Descriptor probe{socket(AF_UNIX, kFlags, 0)};
  if (probe.fd < 0) return false;
  return connect(probe.fd, generic(address), sizeof address) != 0 && errno == ECONNREFUSED;
}

Status bind_path(int fd, const std::string& path, const sockaddr_un& address) {
  if (bind(fd, generic(address), sizeof address) == 0) return success();
  if (errno != EADDRINUSE) return failed(path, "cannot make the socket");
  if (!is_left_over(path, address)) return Error{path, "is in use by another daemon, or is no socket"};
  if (unlink(path.c_str()) != 0) return failed(path, "cannot take the old socket away");
  return bind(fd, generic(address), sizeof address) == 0 ? success() : Status(failed(path, "cannot make the socket"));
}

Result<comms::Endpoint> parse_loopback(const std::string& text) {
  auto endpoint = comms::parse_endpoint(text);
  if (!endpoint) return Error{"", endpoint.error().text()};
  if (!is_loopback(*endpoint))
    return Error{"", "\"" + text + "\" is not an address of loopback (127.0.0.1:PORT or [::1]:PORT)"};
  return endpoint;
}

struct TcpAddress {
  sockaddr_storage bytes{};
  socklen_t length = 0;
  const sockaddr* generic() const { return reinterpret_cast<const sockaddr*>(&bytes); }
};

TcpAddress tcp_address(const comms::Endpoint& endpoint) {
  TcpAddress out;
  if (endpoint.is_ipv4()) {
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(endpoint.port);
    std::memcpy(&v4.sin_addr, endpoint.address.data() + 12, 4);
    std::memcpy(&out.bytes, &v4, sizeof v4);
    out.length = sizeof v4;
  } else {
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(endpoint.port);
    std::memcpy(&v6.sin6_addr, endpoint.address.data(), 16);
    std::memcpy(&out.bytes, &v6, sizeof v6);
    out.length = sizeof v6;
  }
  return out;
}

comms::Endpoint endpoint_of(const sockaddr_storage& address) {
  comms::Endpoint out = comms::Endpoint::ipv4(0, 0, 0, 0, 0);
  if (address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof v4);
    std::memcpy(out.address.data() + 12, &v4.sin_addr, 4);
    out.port = ntohs(v4.sin_port);
  } else {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address, sizeof v6);
    std::memcpy(out.address.data(), &v6.sin6_addr, 16);
    out.port = ntohs(v6.sin6_port);
  }
  return out;
}

comms::Endpoint own_end(int socket) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  (void)getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length);
  return endpoint_of(address);
}

std::vector<gid_t> groups_of(int connection, gid_t primary) {
  std::vector<gid_t> groups(64);
  for (int tries = 0; tries < 2; ++tries) {
    auto bytes = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
    const bool got = getsockopt(connection, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &bytes) == 0;
    groups.resize(bytes / sizeof(gid_t));
    if (got) break;
    if (errno != ERANGE) groups.clear();
  }
  groups.push_back(primary);
  return groups;
}

}  // namespace

Listener::Listener(int descriptor, std::string place)
    : descriptor_(descriptor), spare_(::open("/dev/null", O_RDONLY | O_CLOEXEC)), place_(std::move(place)) {}

Listener::Listener(Listener&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      spare_(std::exchange(other.spare_, -1)),
      place_(std::move(other.place_)),
      group_(other.group_),
      device_(other.device_),
      inode_(std::exchange(other.inode_, 0)) {}

Listener::~Listener() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (spare_ >= 0) ::close(spare_);
  struct stat now {};
  if (inode_ != 0 && lstat(place_.c_str(), &now) == 0 && now.st_ino == inode_ && now.st_dev == device_)
    (void)unlink(place_.c_str());
}

Result<Listener> Listener::at_path(const std::string& path) {
  const auto address = address_of(path);
  if (!address) return address.error();
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST)
    return failed(folder.string(), "cannot make the folder of the control socket");
  Descriptor socket{::socket(AF_UNIX, kFlags, 0)};
  if (socket.fd < 0) return failed(path, "no socket");
  if (auto bound = bind_path(socket.fd, path, *address); !bound) return bound.error();
  struct stat made {};
  if (chmod(path.c_str(), kForEverybody) != 0 || lstat(path.c_str(), &made) != 0 || listen(socket.fd, kBacklog) != 0) {
    Error error = failed(path, "cannot listen");
    (void)unlink(path.c_str());
    return error;
  }
  Listener listener(socket.release(), path);
  listener.group_ = made.st_gid;
  listener.device_ = made.st_dev;
  listener.inode_ = made.st_ino;
  return listener;
}

Result<Listener> Listener::at_loopback(const std::string& text) {
  const auto endpoint = parse_loopback(text);
  if (!endpoint) return endpoint.error();
  const TcpAddress address = tcp_address(*endpoint);
  Descriptor socket{::socket(address.bytes.ss_family, kFlags, 0)};
  const int on = 1;
  if (socket.fd < 0) return failed(text, "no socket");
  (void)setsockopt(socket.fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(socket.fd, address.generic(), address.length) != 0 || listen(socket.fd, kBacklog) != 0)
    return failed(text, "cannot listen");
  std::string place = comms::to_string(own_end(socket.fd));
  return Listener(socket.release(), std::move(place));
}

Listener::Got Listener::accept(int& descriptor) {
  do descriptor = accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  while (descriptor < 0 && (errno == EINTR || errno == ECONNABORTED));
  if (descriptor >= 0) return Got::connection;
  if (errno != EMFILE && errno != ENFILE) return Got::nothing;
  if (spare_ >= 0) {
    ::close(std::exchange(spare_, -1));
    const int unwanted = accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (unwanted >= 0) ::close(unwanted);
  }
  spare_ = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  return Got::no_descriptors;
}

Status check_loopback(const std::string& endpoint) {
  const auto parsed = parse_loopback(endpoint);
  return parsed ? success() : Status(parsed.error());
}

Caller caller_of(int connection, const Listener& listener) {
  if (!listener.group()) {
    sockaddr_storage address{};
    socklen_t length = sizeof address;
    (void)getpeername(connection, reinterpret_cast<sockaddr*>(&address), &length);
    return {false, comms::to_string(endpoint_of(address))};
  }
  ucred peer{};
  socklen_t length = sizeof peer;
  if (getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &length) != 0) return {false, "somebody unknown"};
  const auto groups = groups_of(connection, peer.gid);
  const bool trusted =
      peer.uid == 0 || peer.uid == geteuid() || std::ranges::find(groups, *listener.group()) != groups.end();
  return {trusted, fmt::format("pid {}, uid {}", peer.pid, peer.uid)};
}

}  // namespace onemap::daemon
